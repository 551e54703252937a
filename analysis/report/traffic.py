"""What the traffic paid, and what got through over time."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from scipy.stats import t as student

from analysis.load import Dataset
from analysis.report.drawing import canvas, empty, svg
from analysis.report.intervals import change
from analysis.report.looks import Look, looks
from analysis.report.matching import Match
from analysis.report.parts import Cell, Figure, Quantity, Section, Table, Text, number
from analysis.statistics import Interval, paired_interval

__all__ = ["card_line", "section"]

_MEASURES = (
    ("delay", "delay_s", "distance_m", 1000.0, "s/km"),
    ("mean speed", "distance_m", "time_s", 3.6, "km/h"),
    ("arrivals", "arrived", "hours", 1.0, "1/h"),
)  # name, column, what it is counted over, factor, unit


def _per_run(data: Dataset) -> pd.DataFrame:
    """Sums over every run, by run id."""
    sums = data.traffic.groupby("run_id")[["delay_s", "distance_m", "time_s", "arrived"]].sum()
    runs = data.runs.set_index("run_id")
    return sums.reindex(runs.index, fill_value=0.0).assign(hours=(runs["end_s"] - runs["begin_s"]) / 3600)


def _paired(sums: pd.DataFrame, match: Match, column: str, over: str, factor: float) -> Interval:
    before, after = sums.loc[match.pairs["baseline"]], sums.loc[match.pairs["run"]]
    return paired_interval(
        factor * before[column], factor * after[column], baseline_per=before[over], other_per=after[over]
    )


def card_line(data: Dataset, match: Match) -> list[tuple[str, Text]]:
    """The price, for the answer's card."""
    if not len(match.pairs):
        return []
    name, column, over, factor, unit = _MEASURES[0]
    delay = change(f"{match.group}/card/delay", _paired(_per_run(data), match, column, over, factor), unit)
    return [("price: change in delay", (delay,))]


def section(data: Dataset, matched: Sequence[Match]) -> Section:
    """Change of every measure against the baseline, and the flow over time."""
    sums = _per_run(data)
    rows: list[list[Cell]] = []
    for match in matched:
        if not len(match.pairs):
            continue
        for name, column, over, factor, unit in _MEASURES:
            key = f"{match.group}/traffic/{name}"
            sides = []
            for side in ("baseline", "run"):
                some = sums.loc[match.pairs[side]]
                value = factor * some[column].sum() / some[over].sum() if some[over].sum() else np.nan
                sides.append(Quantity(key=f"{key}/{side}", value=value, unit=unit, n=len(some), of="runs"))
            rows.append([match.group, name, *sides, change(f"{key}/change", _paired(sums, match, column, over, factor), unit)])
    table = Table(
        id="price-table", title="Traffic with AEB against without, same seeds", rows=rows,
        head=("group", "measure", "without", "with", "change"),
        note="All vehicles and all runs together. Crashes block the road, so what an AEB costs by braking and what it saves "
        "by crashes avoided are both in the change.",
    )  # fmt: skip
    figures = [
        _over_time(data, "flow", "Throughput over time", "arrivals per hour", "arrived", None, 3600.0),
        _over_time(data, "speed", "Mean speed over time", "mean speed [km/h]", "distance_m", "time_s", 3.6),
    ]
    return Section(id="traffic", title="What it costs the traffic", figures=figures, tables=[table] if rows else [])


def _over_time(
    data: Dataset, name: str, title: str, label: str, column: str, over: str | None, factor: float
) -> Figure:
    """Mean over the runs of each interval, with the 95 % t interval of that mean."""
    groups = data.by_group()
    look, said = looks(groups), []
    with canvas(2.7) as (figure, axes):
        for group, part in groups.items():
            table = _intervals(part, column, over, factor)
            if table.empty:
                continue
            _line(axes, table, look[group])
            said.append(f"{group}: {number(float(table['mean'].iloc[0]), 0)} in the first interval, "
                        f"{number(float(table['mean'].iloc[-1]), 0)} in the last")  # fmt: skip
        alt = f"{title}. " + ("; ".join(said) + "." if said else "There is no traffic to show.")
        if said:
            axes.set(xlabel="simulated time [s]", ylabel=label)
            axes.set_ylim(bottom=0)
            figure.legend(loc="outside upper left", ncols=1 if len(said) > 2 else 2)
        else:
            empty(axes, "no traffic")
        drawn = svg(figure, f"traffic-{name}", alt)
    note = "Mean over the runs, by interval; shaded: 95 % (t, by seed), where a group has several runs."
    return Figure(id=f"traffic-{name}", title=title, svg=drawn, alt=alt, note=note)


def _intervals(part: Dataset, column: str, over: str | None, factor: float) -> pd.DataFrame:
    """Index begin of the interval; columns `end`, `mean`, `half` (NaN for one run)."""
    done = part.traffic[part.traffic["run_id"].isin(part.runs["run_id"])].assign(begin_s=lambda t: t["begin_s"].round(6))
    sums = done.groupby(["begin_s", "run_id"]).agg(
        {"end_s": "max"} | {c: "sum" for c in (column, over) if c is not None}
    )
    base = sums[over] if over is not None else sums["end_s"] - sums.index.get_level_values("begin_s")
    values = (factor * sums[column] / base).replace([np.inf, -np.inf], np.nan).rename("value")
    by = values.groupby("begin_s")
    n = by.count()
    half = by.std(ddof=1) / np.sqrt(n) * student.ppf(0.975, (n - 1).clip(lower=1))
    ends = sums["end_s"].groupby("begin_s").max()
    return pd.DataFrame({"end": ends, "mean": by.mean(), "half": half.where(n > 1)}).dropna(subset=["mean"])


def _line(axes: Axes, table: pd.DataFrame, look: Look) -> None:
    middle = (table.index.to_numpy(float) + table["end"].to_numpy(float)) / 2
    mean, half = table["mean"].to_numpy(float), table["half"].to_numpy(float)
    axes.plot(middle, mean, color=look.colour, ls=look.style, marker="o", ms=3, label=look.short)
    if np.isfinite(half).any():
        axes.fill_between(middle, np.maximum(mean - half, 0), mean + half, color=look.colour, alpha=0.15, lw=0)
