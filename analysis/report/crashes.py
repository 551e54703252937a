"""What kinds of crashes there were, and how hard."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from analysis.crashes import crash_counts, crash_rates
from analysis.load import Dataset
from analysis.report.drawing import canvas, empty, legend, svg
from analysis.report.intervals import median, records
from analysis.report.looks import ecdf, looks
from analysis.report.parts import Cell, Figure, Quantity, Section, Table, count

__all__ = ["section"]

_KMH = 3.6  # km/h per m/s


def section(data: Dataset, groups: Mapping[str, Dataset]) -> Section:
    """Kinds, rates and impact speeds, by group of runs.

    Args:
        data: all runs.
        groups: `data.by_group()`.
    """
    worst = crash_counts(data, "kind")
    kinds = [k for k in worst.index if k != "total"]
    rows: list[list[Cell]] = []
    for kind in [*kinds, "total"]:
        counts = [count(f"{g}/crashes/{kind}", worst.loc[kind, g]) for g in groups]
        rows.append([kind.replace("_", " "), *counts])
    again = {g: part.crashes["secondary"].astype(bool).sum() for g, part in groups.items()}
    rows.append(["of these secondary", *(count(f"{g}/crashes/secondary", n) for g, n in again.items())])
    rates = {row["group"]: row for row in records(crash_rates(data))}
    rates_table = Table(
        id="crash-rates", title="Crash rate and impact speed",
        head=("group", "crashes", "crashes per million vehicle-km", "median impact speed"),
        rows=[_rate(g, rates[g], part) for g, part in groups.items()],
        note="Rate per million vehicle-km of all vehicles, exact Poisson interval, which takes crashes as independent: "
        "with many secondary crashes it is too narrow. Median with the interval between order statistics.",
    )  # fmt: skip
    return Section(
        id="crashes", title="Crashes", figures=[_kinds(worst.loc[kinds], groups), _speeds(groups)],
        tables=[Table(id="crash-kinds", title="Crashes by kind", head=("kind", *groups), rows=rows), rates_table],
    )  # fmt: skip


def _rate(group: str, rate: Mapping[str, Any], part: Dataset) -> list[Cell]:
    high = rate["high"] if np.isfinite(rate["high"]) else np.nan
    speeds = pd.Series(_KMH * part.crashes["impact_speed_mps"].to_numpy(float))
    return [
        group,
        count(f"{group}/rate/crashes", rate["crashes"]),
        Quantity(
            key=f"{group}/rate", value=rate["per_million_km"], low=rate["low"], high=high,
            n=rate["vehicle_km"], of="vehicle-km",
        ),
        median(f"{group}/impact_speed", speeds, "crashes", "km/h"),
    ]  # fmt: skip


def _kinds(counts: pd.DataFrame, groups: Mapping[str, Dataset]) -> Figure:
    look = looks(groups)
    alt = "Crashes by kind. " + (
        "; ".join(
            f"{str(kind).replace('_', ' ')}: " + ", ".join(f"{g} {counts.loc[kind, g]}" for g in groups)
            for kind in counts.index
        )
        + "."
        if len(counts)
        else "There was no crash."
    )
    with canvas(1.1 + max(len(counts), 1) * (0.18 + 0.19 * len(groups))) as (figure, axes):
        if len(counts):
            thick = 0.8 / len(groups)
            for k, group in enumerate(groups):
                y = np.arange(len(counts)) + (k - (len(groups) - 1) / 2) * thick
                runs = len(groups[group].runs)
                label = f"{look[group].short} ({runs} run{'s' if runs != 1 else ''})"
                bars = axes.barh(y, counts[group] / runs, thick * 0.92, color=look[group].colour, label=label)
                axes.bar_label(bars, [str(n) for n in counts[group]], padding=2, fontsize=8)
            axes.set_yticks(range(len(counts)), [str(kind).replace("_", " ") for kind in counts.index])
            axes.invert_yaxis()
            axes.grid(axis="y", visible=False)
            axes.margins(x=0.12)
            axes.set(xlabel="crashes per run")
            legend(figure, axes)
        else:
            empty(axes, "no crashes")
        drawn = svg(figure, "crash-kinds-figure", alt)
    note = "Crashes per run; the numbers at the bars are those of all runs of a group together."
    return Figure(id="crash-kinds-figure", title="Crashes by kind", svg=drawn, alt=alt, note=note)


def _speeds(groups: Mapping[str, Dataset]) -> Figure:
    values = {g: _KMH * part.crashes["impact_speed_mps"].to_numpy(float) for g, part in groups.items()}
    return ecdf("impact-speeds", "Impact speeds", values, looks(groups), label="impact speed [km/h]", events="crashes")
