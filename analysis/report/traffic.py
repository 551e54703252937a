"""What the traffic paid, and what got through over time."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from analysis.load import Dataset
from analysis.report.drawing import canvas, empty, legend, svg
from analysis.report.intervals import of_row
from analysis.report.looks import Look, looks
from analysis.report.matching import Match
from analysis.report.parts import Cell, Figure, Quantity, Section, Table, Text, number
from analysis.throughput import throughput_over_time

__all__ = ["card_lines", "section"]

_CARD = (("delay on the road", "price: delay on the road"), ("flow", "flow"))
_UNITS = {"1/h": "per h", "1/km": "per km"}
_TIME = (
    ("flow_vph", "Throughput over time", "arrivals per hour", "arrivals"),
    ("speed_kmh", "Mean speed over time", "mean speed [km/h]", "km/h"),
)


def card_lines(match: Match) -> list[tuple[str, Text]]:
    """The price, for the answer's card."""
    if not len(match.pairs):
        return []
    price = {row["figure"]: row for row in _price(match)}
    return [
        (label, (of_row(f"{match.group}/card/{figure}", price[figure], unit=price[figure]["unit"]),))
        for figure, label in _CARD
    ]


def section(data: Dataset, groups: Mapping[str, Dataset], matched: Sequence[Match]) -> Section:
    """Change of every figure against the baseline, and flow and speed over time.

    Args:
        data: all runs.
        groups: `data.by_group()`.
        matched: groups with AEB and what they are compared with.
    """
    rows = [row for match in matched if len(match.pairs) for row in _rows(match)]
    table = Table(
        id="price-table", title="Traffic with AEB against without, same seeds", rows=rows,
        head=("group", "figure", "without", "with", "change"),
        note="All vehicles; rates over all runs together, the other figures per run. Crashes block the road, so what "
        "an AEB costs by braking and what it saves by crashes avoided are both in the change. Delay: time lost on the "
        "road and by waiting for a place to enter. Intervals: the seed is the unit; of the delay per avoided crash, "
        "Fieller's.",
    )  # fmt: skip
    return Section(
        id="traffic",
        title="What it costs the traffic",
        figures=_over_time(data, groups),
        tables=[table] if rows else [],
    )


def _price(match: Match) -> list[dict[str, Any]]:
    # Crashes have their own table.
    rows = [row for row in match.price if row["figure"] != "crashes"]
    return [row | {"unit": _UNITS.get(row["unit"], row["unit"])} for row in rows]


def _rows(match: Match) -> list[list[Cell]]:
    rows: list[list[Cell]] = []
    for row in _price(match):
        figure, unit = row["figure"], row["unit"]
        key = f"{match.group}/traffic/{figure.strip()}"
        sides = [Quantity(key=f"{key}/{side}", value=row[side], unit=unit) for side in ("baseline", "with_aeb")]
        name = f"of it {figure.strip()}" if figure.startswith(" ") else figure
        rows.append([match.group, name, *sides, of_row(f"{key}/change", row, unit=unit)])
    return rows


def _over_time(data: Dataset, groups: Mapping[str, Dataset]) -> list[Figure]:
    """Mean over the runs of each interval, with its interval."""
    known = data.only(pd.Index(data.traffic["run_id"].unique()))
    table = throughput_over_time(known) if len(known.runs) else pd.DataFrame()
    parts = {str(name): part.droplevel(0) for name, part in table.groupby(level=0, sort=False)} if len(table) else {}
    return [_course(name, title, label, unit, looks(groups), parts) for name, title, label, unit in _TIME]


def _course(
    column: str, title: str, label: str, unit: str, look: Mapping[str, Look], groups: Mapping[str, pd.DataFrame]
) -> Figure:
    name, said = f"over-time-{column.partition('_')[0]}", []
    with canvas(2.8) as (figure, axes):
        for group, part in groups.items():
            values = part[[column, f"{column}_low", f"{column}_high"]].dropna(subset=[column])
            if len(values):
                _line(axes, values, look[group])
                first, last = (number(float(values[column].iloc[k]), 0) for k in (0, -1))
                said.append(f"{group} from {first} to {last} {unit}")
        alt = f"{title}. " + (f"First to last interval: {'; '.join(said)}." if said else "There is no traffic to show.")
        if said:
            axes.set(xlabel="time since the begin of the run [s]", ylabel=label)
            axes.set_xlim(left=0)
            axes.set_ylim(0, max(axes.get_ylim()[1], 1))
            legend(figure, axes)
        else:
            empty(axes, "no traffic")
        drawn = svg(figure, name, alt)
    note = (
        "Mean over the runs of a group, by interval; shaded: 95 % of that mean (t, by seed), where there are several."
    )
    return Figure(id=name, title=title, svg=drawn, alt=alt, note=note)


def _line(axes: Axes, values: pd.DataFrame, look: Look) -> None:
    times = values.index.to_frame()
    middle = (times["begin_s"].to_numpy(float) + times["end_s"].to_numpy(float)) / 2
    mean, low, high = values.to_numpy(float).T
    axes.plot(middle, mean, color=look.colour, ls=look.style, marker="o", ms=3, label=look.short)
    if np.isfinite(low).any():
        axes.fill_between(middle, np.maximum(low, 0), high, color=look.colour, alpha=0.15, lw=0)
