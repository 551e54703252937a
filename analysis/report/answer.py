"""The answer first: crashes with every system against the same traffic without, seed by seed."""

from collections.abc import Sequence
from math import isnan

import numpy as np
import pandas as pd

from analysis.load import Dataset
from analysis.report.drawing import FAINT, SERIES, canvas, empty, svg
from analysis.report.intervals import change
from analysis.report.matching import Match
from analysis.report.parts import Card, Cell, Figure, Quantity, Section, Table, Text, count
from analysis.statistics import paired_interval

__all__ = ["cards", "crashes_by_run", "section"]

_MANY = 40  # seeds in a drawing that can still be told apart


def crashes_by_run(data: Dataset, which: str = "all") -> pd.Series:
    """Crashes of every run, by run id: `all`, `primary` ones, or the `serious` injuries expected in them."""
    runs = data.runs["run_id"]
    crashes = data.crashes
    if which == "primary":
        crashes = crashes[~crashes["secondary"].astype(bool)]
    if which == "serious":
        risks = crashes[["striker_serious_risk", "struck_serious_risk"]].sum(axis=1)
        return risks.groupby(crashes["run_id"]).sum().reindex(runs, fill_value=0.0)
    return crashes.groupby("run_id").size().reindex(runs, fill_value=0)


def section(data: Dataset, matched: Sequence[Match], extra: Sequence[Sequence[tuple[str, Text]]]) -> Section:
    """Cards, a drawing seed by seed, and the numbers behind them.

    Args:
        data: all runs.
        matched: groups with AEB and what they are compared with.
        extra: lines for the card of each group.
    """
    figures = [_by_seed(data, match, k) for k, match in enumerate(matched) if len(match.pairs)]
    rows = [row for match in matched if len(match.pairs) for row in _rows(data, match)]
    table = Table(
        id="answer-table", title="With AEB against without, same seeds", rows=rows,
        head=("group", "measure", "without", "with", "avoided per run", "avoided, percent"),
        note="Avoided: without less with, so new crashes count against it; a negative number is an increase. Intervals: "
        "the seed is the unit; studentized bootstrap of the seeds from six on, t below; percent by the log ratio. Primary: "
        "neither vehicle had crashed before. Serious injuries: sum of the risks of the persons for whom there is a curve, "
        "so a lower bound.",
    )  # fmt: skip
    return Section(
        id="answer", title="The answer", cards=cards(data, matched, extra), figures=figures,
        tables=[table] if rows else [],
    )  # fmt: skip


def cards(data: Dataset, matched: Sequence[Match], extra: Sequence[Sequence[tuple[str, Text]]]) -> list[Card]:
    """One card per group with AEB; without one, what there is."""
    result = []
    for match, more in zip(matched, extra, strict=True):
        if len(match.pairs):
            headline, lines = _headline(data, match)
        else:
            own = data.runs[data.runs["run_id"].isin(match.left_out)]
            seen = count(f"{match.group}/crashes/with", own["crashes"].sum())
            headline: Text = (seen, " crashes" if seen.value != 1 else " crash", "; no baseline to compare with")
            lines = [("runs", (count(f"{match.group}/runs", len(own)),))]
        result.append(Card(title=match.group, headline=headline, lines=[*lines, *more]))
    if not matched:
        seen = count("none/crashes/without", len(data.crashes))
        result.append(
            Card(
                title="Baseline alone",
                headline=(seen, " crashes without AEB" if seen.value != 1 else " crash without AEB"),
                lines=[("compared with", ("nothing: these results hold no run with an AEB",))],
            )
        )
    return result


def _headline(data: Dataset, match: Match) -> tuple[Text, list[tuple[str, Text]]]:
    before, after = _totals(data, match, "all")
    key = f"{match.group}/all"
    without, with_ = count(f"{key}/without", before.sum()), count(f"{key}/with", after.sum())
    net = without.value - with_.value
    if not without.value and not with_.value:
        headline: Text = ("No crash, neither without nor with AEB",)
    elif net >= 0:
        headline = (count(f"{key}/net", net), " of ", without, " crashes avoided")
    else:
        headline = (count(f"{key}/more", -net), " crashes more than the ", without, " without AEB")
    percent = _percent(key, before, after)
    lines: list[tuple[str, Text]] = [] if isnan(percent.value) else [("avoided, net of new ones", (percent,))]
    per_run = change(f"{key}/per_run", paired_interval(before, after), "per run", turned=True)
    lines += [("avoided, net", (per_run,))]
    return headline, lines


def _totals(data: Dataset, match: Match, which: str) -> tuple[pd.Series, pd.Series]:
    values = crashes_by_run(data, which)
    return values[match.pairs["baseline"]], values[match.pairs["run"]]


def _percent(key: str, before: pd.Series, after: pd.Series) -> Quantity:
    return change(f"{key}/percent", paired_interval(before, after, percent=True), "%", turned=True)


def _rows(data: Dataset, match: Match) -> list[list[Cell]]:
    rows: list[list[Cell]] = []
    for which, name in (("all", "crashes"), ("primary", "primary crashes"), ("serious", "serious injuries expected")):
        before, after = _totals(data, match, which)
        key, n = f"{match.group}/{which}/table", len(before)
        total = (
            Quantity(key=f"{key}/{side}", value=float(v.sum()), n=n, of="runs" if n > 1 else "run", whole=which != "serious")
            for side, v in (("without", before), ("with", after))
        )
        per_run = change(f"{key}/per_run", paired_interval(before, after), "", turned=True)
        rows.append([match.group, name, *total, per_run, _percent(key, before, after)])
    return rows


def _by_seed(data: Dataset, match: Match, k: int) -> Figure:
    """Crashes of every seed, without and with."""
    before, after = (v.to_numpy() for v in _totals(data, match, "all"))
    seeds = match.pairs["seed"].to_numpy()
    order = np.lexsort((seeds, -before))
    before, after, seeds = before[order], after[order], seeds[order]
    name, y = f"by-seed-{k}", np.arange(len(seeds))
    fewer, more = int((after < before).sum()), int((after > before).sum())
    alt = (
        f"Crashes of {len(seeds)} seeds without AEB and with {match.group}: fewer in {fewer}, more in {more}, "
        f"equal in {len(seeds) - fewer - more}."
    )
    with canvas(1.3 + min(len(seeds), _MANY) * 0.15) as (figure, axes):
        if not len(seeds):
            empty(axes, "no pairs of runs")
        axes.hlines(y, before, after, color=FAINT, lw=1)
        axes.plot(before, y, "o", color=SERIES[0], ms=5, label="without AEB")
        axes.plot(after, y, "D", color=SERIES[1 + k % (len(SERIES) - 1)], ms=4.5, label="with")
        axes.set(xlabel="crashes in the run", ylabel="seed", ylim=(len(seeds) - 0.4, -0.6))
        axes.set_yticks(y if len(seeds) <= _MANY else [], [str(s) for s in seeds] if len(seeds) <= _MANY else [])
        axes.set_xlim(left=-0.5)
        axes.xaxis.get_major_locator().set_params(integer=True)
        axes.grid(axis="y", visible=False)
        figure.legend(loc="outside upper left", ncols=2)
        drawn = svg(figure, name, alt)
    note = f"{alt} Each line is one seed: the same traffic and drivers twice."
    return Figure(id=name, title=f"Crashes by seed: {match.group}", svg=drawn, alt=alt, note=note)
