"""Where on the network it happened."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from numpy.typing import NDArray

from analysis.load import Dataset
from analysis.report.drawing import FAINT, GRID, INK, PAGE, SERIES, VERDICTS, canvas, svg
from analysis.report.network import lanes
from analysis.report.parts import Figure, Section, number

__all__ = ["section"]

_MARGIN = 0.08  # of what is shown, around it
_LEAST = 60.0  # m shown at least
_SQUARE = 4.0  # a longer view is stretched across
_CLOSE = 0.6  # height by width of a detail of a network that is not flat
_FLAT = 2.7  # inches, height of a stretched map
_ROW = 0.19  # inches that a further row of the legend takes
_HEADS, _ACROSS, _TALL = 0.95, 3.5, 1.3  # inches around a map and across it; height of the tallest by its width

Lines = Sequence[NDArray[np.float64]]
View = tuple[float, float, float, float]  # x from, x to, y from, y to [m]


def section(data: Dataset, networks: Mapping[str, Path]) -> Section:
    """A map for every group of runs, and where the events crowd, one of that place.

    Args:
        data: all runs.
        networks: scenario -> its .net.xml, for those that are known.
    """
    figures: list[Figure] = []
    missing = []
    names = data.groups()
    for scenario in sorted(data.runs["scenario"].unique()):
        one = data.only(pd.Index(data.runs.loc[data.runs["scenario"] == scenario, "run_id"]))
        roads = lanes(networks[scenario]) if scenario in networks else None
        if roads is None:
            missing.append(scenario)
        for group in dict.fromkeys(names[names.index.isin(one.runs["run_id"])]):
            part = one.only(names.index[names == group])
            figures += _maps(f"map-{len(figures)}", scenario, group, part, one, roads)
    text = []
    if missing:
        text = [(
            f"The network of {', '.join(missing)} is not where it was when the runs were made, so the points stand "
            "alone.",
        )]  # fmt: skip
    return Section(id="places", title="Where it happened", figures=figures, text=text)


def _maps(
    name: str, scenario: str, group: str, part: Dataset, everything: Dataset, roads: Lines | None
) -> list[Figure]:
    # All groups of one scenario share their views, so that the maps can be laid beside each other.
    events = pd.concat([everything.crashes[["x_m", "y_m"]], everything.interventions[["x_m", "y_m"]]]).dropna()
    points = events.to_numpy(float)
    whole = _view(np.concatenate([*(roads or []), points]) if roads or len(points) else np.zeros((1, 2)))
    views = {"": whole}
    if roads and len(points):
        flat = (whole[1] - whole[0]) / (whole[3] - whole[2]) > _SQUARE
        near = _view(points, 0.0 if flat else _CLOSE)
        share = max((near[1] - near[0]) / (whole[1] - whole[0]), (near[3] - near[2]) / (whole[3] - whole[2]))
        if share < 0.6:
            views = {"": whole, "detail": near}
    if list(views) == ["", "detail"] and not len(part.crashes) and not len(part.interventions):
        views = {"": whole}
    title = group if f"scenario {scenario}" in group else f"{scenario}, {group}"
    return [
        _map(f"{name}-{k}", f"{title}{': detail' if which else ''}", part, roads, view, detail=bool(which))
        for k, (which, view) in enumerate(views.items())
    ]


def _view(points: NDArray[np.float64], flattest: float = 0.0) -> View:
    """What holds the points, with some margin; its height at least so much of its width."""
    (x0, y0), (x1, y1) = points.min(axis=0), points.max(axis=0)
    wide, high = max(x1 - x0, _LEAST), max(y1 - y0, _LEAST / _SQUARE)
    high = max(high, flattest * wide)
    pad = _MARGIN * wide, _MARGIN * high
    x, y = (x0 + x1) / 2, (y0 + y1) / 2
    return (x - wide / 2 - pad[0], x + wide / 2 + pad[0], y - high / 2 - pad[1], y + high / 2 + pad[1])


def _map(name: str, title: str, part: Dataset, roads: Lines | None, view: View, *, detail: bool) -> Figure:
    wide, high = view[1] - view[0], view[3] - view[2]
    flat = wide / high > _SQUARE
    alt = _alt(part, roads)
    with canvas(_FLAT if flat else _HEADS + _ACROSS * min(high / wide, _TALL)) as (figure, axes):
        if roads:
            gap = np.full((1, 2), np.nan)
            line = np.concatenate([p for road in roads if _near(road, view) for p in (road, gap)])
            axes.plot(line[:, 0], line[:, 1], color=GRID, lw=1.6 if flat or detail else 1.2, zorder=1)
        _interventions(axes, part.interventions)
        crashes = part.crashes
        first = ~crashes["secondary"].astype(bool)
        for some, face, label in ((crashes[first], INK, "crash"), (crashes[~first], FAINT, "secondary crash")):
            if len(some):
                axes.plot(some["x_m"], some["y_m"], "X", color=face, mec=PAGE, mew=0.7, ms=8, zorder=4,
                          label=f"{label} ({len(some)})")  # fmt: skip
        axes.set(xlabel="x [m]", ylabel="y [m]", xlim=view[:2], ylim=view[2:])
        axes.grid(visible=False)
        if not flat:
            axes.set_aspect("equal", anchor="N")
        if shown := len(axes.get_legend_handles_labels()[1]):
            figure.legend(loc="outside upper left", ncols=2)
            figure.set_figheight(figure.get_figheight() + _ROW * ((shown - 1) // 2))
        drawn = svg(figure, name, alt)
    note = alt
    if flat:
        note += f" Across the road drawn larger than along it: {number(wide, 0)} m by {number(high, 0)} m are shown."
    return Figure(id=name, title=title, svg=drawn, alt=alt, note=note)


def _near(road: NDArray[np.float64], view: View) -> bool:
    (x0, y0), (x1, y1) = road.min(axis=0), road.max(axis=0)
    return bool(x1 >= view[0] and x0 <= view[1] and y1 >= view[2] and y0 <= view[3])


def _interventions(axes: Axes, some: pd.DataFrame) -> None:
    """By verdict where there are any, else by phase; warnings are faint, for there are many."""
    if (some["verdict"].fillna("") != "").any():
        for verdict, colour in VERDICTS.items():
            rows = some[some["verdict"] == verdict]
            if len(rows):
                axes.plot(rows["x_m"], rows["y_m"], "o", color=colour, ms=4.5, mec=PAGE, mew=0.5, zorder=3,
                          label=f"{verdict} ({len(rows)})")  # fmt: skip
        return
    for phases, colour, size, label in (
        (("warn",), SERIES[0], 2.5, "warning"),
        (("partial_brake", "full_brake"), SERIES[1], 4.0, "braking"),
    ):
        rows = some[some["phase"].isin(phases)]
        if len(rows):
            axes.plot(rows["x_m"], rows["y_m"], "o", color=colour, ms=size, mec=PAGE, mew=0.4, zorder=2 + (size > 3),
                      label=f"{label} ({len(rows)})")  # fmt: skip


def _alt(part: Dataset, roads: Lines | None) -> str:
    c, i, n = len(part.crashes), len(part.interventions), len(part.runs)
    net = f"on the {len(roads)} lanes of the network" if roads else "without the network, which is not known here"
    text = f"{c} crash{'es' if c != 1 else ''} and {i} intervention{'s' if i != 1 else ''} "
    text += f"in {n} run{'s' if n != 1 else ''}, {net}."
    points = part.crashes if c else part.interventions
    if len(points):
        x, y = (points[axis].quantile([0.1, 0.9]).to_numpy() for axis in ("x_m", "y_m"))
        text += (
            f" Four of five {'crashes' if c else 'interventions'} lie at x {number(x[0], 0)} to {number(x[1], 0)} m"
            f" and y {number(y[0], 0)} to {number(y[1], 0)} m."
        )  # fmt: skip
    return text
