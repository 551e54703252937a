"""Figures of test cases, drawn as the sources draw theirs. No pyplot, so no display is needed, and threads may draw."""

from collections.abc import Collection, Mapping, Sequence
from itertools import cycle
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
import pandas as pd
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.ticker import MultipleLocator

from aeb_sumo.drive import Drive, body_distance
from aeb_sumo.errors import InputError
from aeb_sumo.soa import Floats
from aeb_sumo.strategies.base import Phase
from aeb_sumo.units import to_kmh
from aeb_sumo.vehicle.inverse_dynamics import Sedan, pressure_of, throttle_of
from sumo_nets.left_turn.sources import OFFSET, crossing, start_of_turn
from sumo_nets.turning_path import YAN_TABLE_3

__all__ = ["KINDS", "Figure", "approach", "friction", "pedals", "repeats", "save", "turning_paths"]

KINDS = ("svg", "png")
"""Kinds of file that `save` writes."""

# Okabe and Ito's palette, safe for the colour-blind; the styles tell the lines apart in black and white.
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#AA4499", "#000000", "#E69F00")
_STYLES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (6, 2, 1, 2)), (0, (1, 1.2)), (0, (3, 1, 1, 1, 1, 1)), (0, (9, 3)))
_MARKERS = ("o", "s", "^", "D", "v", "P")
_GREY = "0.45"
_TTC = 6.0  # s, top of the TTC panel
_MOVES = 0.05  # m/s2, below this nothing happens any more
_AFTER = 1.0  # s of the time axis after everything has ended
_DPI = 160
_AROUND = 4.0  # m of road around the turning paths
_NEAR = 5.0  # m of road on each side of where a turn is shown in detail

_LOCK = Lock()  # matplotlib takes the salt of the ids in an SVG from a global setting only


def approach(title: str, drives: Drive | Mapping[str, Drive], *, ttc: bool = False) -> Figure:
    """Signal, gap, speeds and deceleration over time, of one drive or of several in the same panels.

    Curves end at a crash, which is marked with a cross.

    Args:
        title: of the figure.
        drives: one, or several by name.
        ttc: whether to draw the TTC too, up to 6 s.
    """
    named = {"ego": drives} if isinstance(drives, Drive) else dict(drives)
    figure = _empty(7.0, 8.6 if ttc else 7.2)
    figure.suptitle(title)
    heights = [0.7, *([1.0] if ttc else []), 1.0, 1.0, 1.0]
    panels: list[Axes] = list(figure.subplots(len(heights), 1, sharex=True, height_ratios=heights))
    signal, gap, speed, decel = panels[0], *panels[-3:]
    leads = _leads(named)
    for name, drive in leads.items():
        speed.plot(*_until_end(drive, to_kmh(_column(drive.target, "speed_mps"))), color=_GREY, lw=1.0, label=name)
    handles = []
    for k, (drive, look) in enumerate(zip(named.values(), _looks(), strict=False)):
        phases = np.minimum(_column(drive.ego, "phase"), Phase.PARTIAL_BRAKE)
        # Staircases that coincide are moved apart a little.
        signal.plot(*_until_end(drive, phases + 0.06 * k), drawstyle="steps-post", **look)
        (line,) = gap.plot(*_until_end(drive, drive.gap), **look)
        handles.append(line)
        speed.plot(*_until_end(drive, to_kmh(_column(drive.ego, "speed_mps"))), **look)
        decel.plot(*_until_end(drive, _deceleration(drive)), **look)
        if ttc:
            finite = np.where(np.isfinite(drive.ttc) & (drive.gap > 0), drive.ttc, np.nan)
            panels[1].plot(*_until_end(drive, finite), **look)
        if drive.crashed:
            for panel, values in ((gap, drive.gap), (speed, to_kmh(_column(drive.ego, "speed_mps")))):
                x, y = _until_end(drive, values)
                panel.plot(x[-1], y[-1], marker="X", ms=8, color=look["color"], mec="black", ls="none", zorder=5)
    if ttc:
        panels[1].set(ylabel="TTC [s]", ylim=(0.0, _TTC))
    signal.set(ylabel="signal [-]", ylim=(-0.2, 2.4 + 0.06 * len(named)), yticks=[0, 1, 2])
    signal.set_yticklabels(["0 none", "1 warning", "2 braking"])
    gap.set(ylabel="gap [m]")
    gap.set_ylim(bottom=min(0.0, gap.get_ylim()[0]))
    speed.set(ylabel="speed [km/h]")
    speed.set_ylim(bottom=min(-1.0, speed.get_ylim()[0]))
    decel.set(ylabel="deceleration [m/s²]")
    labels = [*named, *leads]
    handles += speed.lines[: len(leads)]
    if any(d.crashed for d in named.values()):
        handles.append(_sample(marker="X", color="white", mec="black", ls="none", ms=8))
        labels.append("crash")
    _finish(figure, panels, named.values(), handles, labels)
    return figure


def pedals(title: str, drive: Drive) -> Figure:
    """Throttle and brake pressure that the drive takes, by the inverse dynamics of Zhao et al. 2025 (eqs. 8 to 11).

    Args:
        title: of the figure.
        drive: one drive.
    """
    figure = _empty(7.0, 4.2)
    figure.suptitle(title)
    panels: list[Axes] = list(figure.subplots(2, 1, sharex=True))
    car, speed, decel = Sedan(), _column(drive.ego, "speed_mps"), _deceleration(drive)
    look: dict[str, Any] = {"color": _COLOURS[0], "lw": 1.6}
    throttle = np.where((decel > _MOVES) | (speed <= 0), 0.0, throttle_of(car, accel=-decel, speed=speed))
    pressure = pressure_of(car, decel=np.maximum(decel, 0.0), speed=speed, mu=_column(drive.ego, "mu"))
    panels[0].plot(*_until_end(drive, throttle), **look)
    panels[1].plot(*_until_end(drive, pressure / 1e6), **look)
    panels[0].set(ylabel="throttle [-]", ylim=(-0.02, None))
    panels[1].set(ylabel="pressure [MPa]")
    _finish(figure, panels, [drive], [], [])
    return figure


def friction(title: str, drive: Drive) -> Figure:
    """Friction coefficient of the road and what the ego takes it for, with the ego's deceleration below.

    Args:
        title: of the figure.
        drive: of an ego that knows or estimates the friction.
    """
    figure = _empty(7.0, 5.0)
    figure.suptitle(title)
    panels: list[Axes] = list(figure.subplots(2, 1, sharex=True, height_ratios=[1.4, 1.0]))
    mu, decel = panels
    truth, known = _column(drive.ego, "mu"), _column(drive.ego, "mu_known")
    mu.plot(*_until_end(drive, truth), color=_GREY, lw=2.6, drawstyle="steps-post", label="road")
    mu.plot(*_until_end(drive, known), color=_COLOURS[1], ls=_STYLES[1], lw=1.6, label="estimate")
    mu.set(ylabel="friction coefficient [-]")
    mu.set_ylim(0.0, 1.15 * float(np.nanmax([truth, known])))
    decel.plot(*_until_end(drive, _deceleration(drive)), color=_COLOURS[0], lw=1.6)
    decel.set(ylabel="deceleration [m/s²]")
    _finish(figure, panels, [drive], list(mu.lines), ["road", "estimate"])
    return figure


def repeats(
    title: str,
    values: Mapping[str, Sequence[float] | Floats],
    unit: str,
    window: tuple[float, float] | None,
    *,
    published: Mapping[str, Sequence[float] | Floats] | None = None,
) -> Figure:
    """One value of every repeat, by group.

    Args:
        title: of the figure: the quantity.
        values: of the repeats, in order, by group.
        unit: of the values.
        window: where a test wants them; shaded.
        published: the same values as printed, by group; drawn hollow.
    """
    printed = published or {}
    unit = unit.replace("m/s2", "m/s²")
    figure = _empty(7.0, 4.6)
    figure.suptitle(title)
    panel: Axes = figure.subplots()
    handles: list[Line2D | Patch] = []
    labels: list[str] = []
    groups = list(dict.fromkeys([*values, *printed]))
    for group, colour, style, marker in zip(groups, cycle(_COLOURS), cycle(_STYLES), cycle(_MARKERS), strict=False):
        for series, more in ((values, {"ls": style}), (printed, {"ls": "none", "mfc": "none", "ms": 9})):
            if group in series:
                count = range(1, len(series[group]) + 1)
                panel.plot(count, series[group], color=colour, marker=marker, lw=1.4, **more)
        handles.append(_sample(color=colour, marker=marker, ls=style))
        labels.append(group)
    everything = np.concatenate([np.asarray(v, float) for v in (*values.values(), *printed.values())])
    low, high = float(np.nanmin(everything)), float(np.nanmax(everything))
    if window is not None:
        # Some of the window is always in view.
        low, high = min(low, window[1]), max(high, window[0])
        panel.axhspan(*window, color="0.9", zorder=0)
        for edge in window:
            panel.axhline(edge, color=_GREY, lw=0.8)
        handles.append(Patch(facecolor="0.9", edgecolor=_GREY))
        labels.append(f"wanted: {window[0]:g} to {window[1]:g} {unit}")
    if printed:
        handles += [
            _sample(color=_GREY, marker="o", ls="-"),
            _sample(color=_GREY, marker="o", mfc="none", ms=9, ls="none"),
        ]
        labels += ["here", "published"]
    margin = 0.08 * (high - low) or 0.5
    panel.set(xlabel="repeat", ylabel=f"{title} [{unit}]")
    panel.set_ylim(low - margin, high + margin)
    longest = max(len(v) for v in (*values.values(), *printed.values()))
    panel.set_xticks(range(1, longest + 1))
    panel.grid(visible=True, color="0.85", lw=0.6)
    _legend(figure, handles, labels)
    return figure


def turning_paths(drives: Mapping[str, Drive]) -> Figure:
    """Plan of left turns across an e-bike, all beginning in the same point, and each where it was closest.

    Thick: where the middle of a front bumper went, up to a crash if there is one. Thin: the path of Table 3. Grey: the
    e-bike's. The bodies are drawn where they were closest; a cross is where the paths cross.

    Args:
        drives: of `aeb_sumo.scenarios.cases.left_turn`, by name.
    """
    figure = _empty(9.0, max(6.0, 2.4 * len(drives)))
    grid = figure.add_gridspec(max(len(drives), 1), 2, width_ratios=[2.2, 1.0])
    plan = figure.add_subplot(grid[:, 0])
    left, top = OFFSET, 0.0
    handles = [
        _sample(color="black", lw=0.6),
        _sample(color=_GREY, lw=1.6),
        _sample(color="black", marker="x", ms=8, mew=1.6, ls="none"),
    ]
    labels = ["Table 3", "e-bike", "crossing point"]
    for k, ((name, drive), look) in enumerate(zip(drives.items(), _looks(), strict=False)):
        speed = _nominal(drive)
        forward, aside = YAN_TABLE_3[speed].points(0.1).T
        left, top = max(left, float(aside.max())), max(top, float(forward.max()))
        detail = figure.add_subplot(grid[k, 1])
        middle = _turn(plan, drive, speed, look)
        _turn(detail, drive, speed, look)
        detail.set(ylabel="ahead [m]", xlim=(middle[0] - _NEAR, middle[0] + _NEAR))
        detail.set(ylim=(middle[1] - _NEAR, middle[1] + _NEAR), aspect="equal")
        closest = "crash" if drive.crashed else f"{float(np.min(body_distance(drive.ego, drive.target))):.2f} m apart"
        detail.xaxis.set_major_locator(MultipleLocator(4))
        detail.yaxis.set_major_locator(MultipleLocator(4))
        detail.set_title(f"{name}: {closest}", fontsize="medium")
        handles.insert(k, _sample(**look))
        labels.insert(k, name)
    figure.axes[-1].set(xlabel="to the right [m]")
    plan.set(xlabel="to the right of the start of the turn [m]", ylabel="ahead of the start of the turn [m]")
    plan.set(xlim=(-left - _AROUND, _AROUND), ylim=(-2 * _AROUND, top + 2 * _AROUND), aspect="equal")
    for panel in figure.axes:
        panel.grid(visible=True, color="0.9", lw=0.6)
        panel.set_axisbelow(True)
    _legend(figure, handles, labels)
    return figure


def _turn(panel: Axes, drive: Drive, speed: int, look: dict[str, Any]) -> tuple[float, float]:
    """Draw one turn.

    Returns:
        Half-way between the crossing point and the middle of the car when the two were closest.
    """
    forward, aside = YAN_TABLE_3[speed].points(0.1).T
    x0, y0 = start_of_turn(speed)
    last = drive.first(drive.time >= drive.crash_time) if drive.crashed else -1
    closest = last if drive.crashed else int(np.argmin(body_distance(drive.ego, drive.target)))
    panel.plot(-aside, forward, color="black", lw=0.6)
    for vehicle, line in ((drive.target, {"color": _GREY, "lw": 1.6}), (drive.ego, look)):
        x, y = _column(vehicle, "x_m") - x0, _column(vehicle, "y_m") - y0
        stop = len(x) if last < 0 else last + 1
        panel.plot(x[:stop], y[:stop], **line)
        row = vehicle.iloc[closest]
        length, width = float(row["length_m"]), float(row["width_m"])
        front, angle = (float(x[closest]), float(y[closest])), float(row["heading_rad"])
        at = (front[0] - length, front[1] - width / 2)
        panel.add_patch(
            Rectangle(
                at, length, width, angle=np.degrees(angle), rotation_point=front, lw=1.0,
                facecolor=line["color"], edgecolor="black", alpha=0.45,
            )
        )  # fmt: skip
    ahead = crossing(speed)[1]
    panel.plot(-OFFSET, ahead, marker="x", ms=8, mew=1.6, color="black", ls="none", zorder=5)
    # The ego is the one drawn last.
    back = front[0] - length / 2 * np.cos(angle), front[1] - length / 2 * np.sin(angle)
    return float(back[0] - OFFSET) / 2, float(back[1] + ahead) / 2


def save(figures: Mapping[str, Figure], folder: Path, kind: str) -> list[Path]:
    """Write figures to files named after them; equal figures give equal bytes.

    Args:
        figures: by name.
        folder: where to; made if it does not exist.
        kind: one of `KINDS`.

    Raises:
        InputError: Another kind, or a file or folder that cannot be written.
    """
    if kind not in KINDS:
        raise InputError(f"unknown kind of figure {kind!r}; there are: {', '.join(KINDS)}")
    metadata = {"Date": None} if kind == "svg" else {"Software": None}
    result = []
    path = folder
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, figure in figures.items():
            path = folder / f"{name}.{kind}"
            # Laid out once: every further layout would move things by a fraction of a pixel.
            figure.draw_without_rendering()
            figure.set_layout_engine("none")
            with _LOCK, rc_context({"svg.hashsalt": "aeb-sumo"}):
                figure.savefig(path, format=kind, dpi=_DPI, metadata=metadata)
            result.append(path)
    except OSError as error:
        raise InputError(f"cannot write figures to {path}: {error.strerror}") from None
    return result


def _empty(width: float, height: float) -> Figure:
    """A figure of this size [in]."""
    return Figure(figsize=(width, height), layout=ConstrainedLayoutEngine(w_pad=0.1, h_pad=0.08, hspace=0.0))


def _looks() -> "cycle[dict[str, Any]]":
    return cycle([{"color": c, "ls": s, "lw": 1.6} for c, s in zip(_COLOURS, _STYLES, strict=True)])


def _column(vehicle: pd.DataFrame, name: str) -> Floats:
    return vehicle[name].to_numpy(float)


def _deceleration(drive: Drive) -> Floats:
    """(k,) what the ego loses speed with, braked by whom ever [m/s2]."""
    return -_column(drive.ego, "accel_mps2")


def _until_end(drive: Drive, values: Floats) -> tuple[Floats, Floats]:
    """Time and values, up to a crash."""
    kept = drive.time <= drive.crash_time if drive.crashed else np.full(len(drive.time), True)
    return drive.time[kept], values[kept]


def _end(drive: Drive) -> float:
    """When there is nothing more to see [s]."""
    if drive.crashed:
        return drive.crash_time
    moves = (_column(drive.ego, "phase") > 0) | (np.abs(_deceleration(drive)) > _MOVES)
    return float(drive.time[np.flatnonzero(moves)[-1] if moves.any() else -1])


def _leads(drives: Mapping[str, Drive]) -> dict[str, Drive]:
    """The drives whose leads have to be drawn, by label: only the longest one if all leads do the same."""
    longest = max(drives.values(), key=lambda d: len(_until_end(d, d.time)[0]))
    whole = (_column(longest.target, "speed_mps"), longest.time)
    for drive in drives.values():
        time, speed = _until_end(drive, _column(drive.target, "speed_mps"))
        if not np.allclose(speed, np.interp(time, whole[1], whole[0]), atol=0.1):
            return {f"lead, {name}": d for name, d in drives.items()}
    return {"lead": longest}


def _nominal(drive: Drive) -> int:
    """Speed of the row of Table 3 that was driven [km/h]."""
    speed = float(to_kmh(_column(drive.ego, "speed_mps"))[0])
    return min(YAN_TABLE_3, key=lambda v: abs(v - speed))


def _sample(**look: Any) -> Line2D:
    return Line2D([], [], **look)


def _finish(
    figure: Figure, panels: Sequence[Axes], drives: Collection[Drive], handles: list[Any], labels: list[str]
) -> None:
    """Time axis, grid and legend."""
    last = min(max(_end(d) for d in drives) + _AFTER, max(float(d.time[-1]) for d in drives))
    for panel in panels:
        panel.grid(visible=True, color="0.85", lw=0.6)
    panels[-1].set(xlabel="time [s]", xlim=(0.0, last))
    figure.align_ylabels(panels)
    _legend(figure, handles, labels)


def _legend(figure: Figure, handles: list[Any], labels: list[str]) -> None:
    """Below the panels, in as few rows as fit."""
    if not labels:
        return
    sizes = np.array([0.8 + 0.08 * len(label) for label in labels])  # in, roughly
    columns = len(labels)
    while columns > 1 and sum(part.max() for part in np.array_split(sizes, columns)) > figure.get_figwidth():
        columns -= 1
    figure.legend(handles, labels, loc="outside lower center", ncols=columns, frameon=False, handlelength=3.0)
