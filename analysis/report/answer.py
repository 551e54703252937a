"""The answer first: crashes with every system against the same traffic without, seed by seed."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.ticker import MaxNLocator

from analysis.load import Dataset
from analysis.planning import planning
from analysis.report.drawing import FAINT, SERIES, canvas, svg
from analysis.report.intervals import of_row, records
from analysis.report.matching import Match
from analysis.report.parts import Card, Cell, Figure, Quantity, Section, Table, Text, count

__all__ = ["section"]

Lines = Sequence[tuple[str, Text]]
_MANY = 40  # seeds in a drawing that can still be told apart


def section(
    matched: Sequence[Match], extra: Mapping[str, Lines], figures: Mapping[str, Figure], data: Dataset
) -> Section:
    """Cards, a drawing seed by seed, and the numbers behind them.

    Args:
        matched: groups with AEB and what they are compared with.
        extra: lines for the card of each group.
        figures: a drawing to stand beside that of each group.
        data: all runs.
    """
    compared = [m for m in matched if len(m.pairs)]
    rows = [row for match in compared for row in _rows(match)]
    drawn = []
    for k, match in enumerate(matched):
        drawn += [_by_seed(match, k)] if len(match.pairs) else []
        drawn += [figures[match.group]] if match.group in figures else []
    table = Table(
        id="answer-table", title="Crashes with AEB against without, same seeds", rows=rows,
        head=("group", "measure", "per run without", "per run with", "avoided per run", "avoided, percent"),
        note="Avoided: without less with, so new crashes count against it; a negative number is an increase. Primary: "
        "neither vehicle had crashed before. Injuries and deaths expected: sums of the risks of the persons for whom "
        f"there is a curve, so lower bounds. Methods of the intervals: {_methods(compared)}.",
    )  # fmt: skip
    return Section(
        id="answer", title="The answer", cards=_cards(matched, extra, data),
        figures=drawn, tables=[table] if rows else [],
    )  # fmt: skip


def _methods(compared: Sequence[Match]) -> str:
    """How the intervals were found."""
    known = {row[name] for match in compared for row in match.effect for name in ("method", "percent_method")}
    return "; ".join(sorted(known - {"none"})) or "none, as nothing is known of the spread"


def _cards(matched: Sequence[Match], extra: Mapping[str, Lines], data: Dataset) -> list[Card]:
    """One card per group with AEB; without one, what there is."""
    result = []
    for match in matched:
        if len(match.pairs):
            headline, lines = _headline(match)
        else:
            seen = int(data.crashes["run_id"].isin(match.left_out).sum())
            headline = (
                count(f"{match.group}/crashes/with", seen),
                f" {_noun(seen)} with AEB; no baseline to compare with",
            )
            lines = [("runs", (count(f"{match.group}/runs", len(match.left_out)),))]
        result.append(Card(title=match.group, headline=headline, lines=[*lines, *extra[match.group]]))
    if not matched:
        seen = len(data.crashes)
        headline = (count("none/crashes/without", seen), f" {_noun(seen)} without AEB")
        lines = [("compared with", ("nothing: there is no run with an AEB here",))]
        result.append(Card(title="Baseline alone", headline=headline, lines=lines))
    return result


def _noun(n: float) -> str:
    return "crash" if n == 1 else "crashes"


def _headline(match: Match) -> tuple[Text, list[tuple[str, Text]]]:
    """Crashes avoided, in all runs together, and its intervals."""
    before, after = (_crashes_of(match, side).sum() for side in ("baseline", "run"))
    key = f"{match.group}/crashes"
    without, net = count(f"{key}/without", before), before - after
    lines: list[tuple[str, Text]] = [("compared", (_runs(key, match),))]
    if not before and not after:
        return ("No crash, neither without AEB nor with it",), lines
    if net >= 0:
        headline: Text = (count(f"{key}/net", net), " of ", without, f" {_noun(before)} avoided, net")
    else:
        headline = (count(f"{key}/more", -net), f" {_noun(-net)} more than the ", without, " without AEB")
    row = next(row for row in match.effect if row["figure"] == "crashes")
    if before:
        lines.append(("avoided, net, in percent", (of_row(f"{key}/percent", row, "percent", unit="%", avoided=True),)))
    lines.append(("avoided, net, per run", (of_row(f"{key}/per_run", row, avoided=True),)))
    return headline, [*lines, *_still_needed(key, match)]


def _still_needed(key: str, match: Match) -> Lines:
    """Seeds until the percentage is known to 10 points."""
    row = next(row for row in records(planning(match.both)) if row["figure"] == "reduction of crashes")
    if np.isnan(row["seeds_missing"]):
        return []
    needed = Quantity(key=f"{key}/seeds_needed", value=row["seeds_needed"], whole=True)
    return [(f"seeds for an interval of ±{row['wanted']:g} percentage points", ("about ", needed))]


def _runs(key: str, match: Match) -> Quantity:
    n = len(match.pairs)
    return Quantity(key=f"{key}/pairs", value=n, unit=f"pair{'' if n == 1 else 's'} of runs, same seed", whole=True)


def _crashes_of(match: Match, side: str) -> pd.Series:
    """Crashes of the runs of one side, `baseline` or `run`, in the order of the pairs."""
    by_run = match.both.crashes.groupby("run_id").size()
    return by_run.reindex(match.pairs[side], fill_value=0)


def _rows(match: Match) -> list[list[Cell]]:
    rows: list[list[Cell]] = []
    for row in match.effect:
        if row["unit"] == "1/run":  # the others are the traffic's
            key = f"{match.group}/effect/{row['figure']}"
            sides = [Quantity(key=f"{key}/{side}", value=row[side]) for side in ("baseline", "with_aeb")]
            changes = [of_row(f"{key}/avoided", row, avoided=True)]
            changes += [of_row(f"{key}/percent", row, "percent", unit="%", avoided=True)]
            rows.append([match.group, row["figure"], *sides, *changes])
    return rows


def _by_seed(match: Match, k: int) -> Figure:
    """Crashes of every seed, without and with."""
    before, after = (_crashes_of(match, side).to_numpy() for side in ("baseline", "run"))
    seeds = match.pairs["seed"].to_numpy()
    order = np.lexsort((seeds, -before))
    before, after, seeds = before[order], after[order], seeds[order]
    name, y = f"by-seed-{k}", np.arange(len(seeds))
    fewer, more = int((after < before).sum()), int((after > before).sum())
    alt = (
        f"Crashes of {len(seeds)} seed{'s' if len(seeds) != 1 else ''} without AEB and with {match.group}: "
        f"fewer in {fewer}, more in {more}, equal in {len(seeds) - fewer - more}."
    )
    with canvas(1.3 + min(len(seeds), _MANY) * 0.15) as (figure, axes):
        axes.hlines(y, before, after, color=FAINT, lw=1)
        axes.plot(before, y, "o", color=SERIES[0], mfc="none", mew=1.4, ms=7.5, label="without AEB")
        axes.plot(after, y, "o", color=SERIES[1 + k % (len(SERIES) - 1)], ms=4, label="with")
        axes.set(xlabel="crashes in the run", ylabel="seed", ylim=(len(seeds) - 0.4, -0.6))
        axes.set_yticks(y if len(seeds) <= _MANY else [], [str(s) for s in seeds] if len(seeds) <= _MANY else [])
        axes.set_xlim(-0.5, max(before.max(), after.max(), 1) + 0.5)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.grid(axis="y", visible=False)
        figure.legend(loc="outside upper left", ncols=2)
        drawn = svg(figure, name, alt)
    note = f"{alt} Each line is one seed: the same traffic and drivers twice."
    return Figure(id=name, title=f"Crashes by seed: {match.group}", svg=drawn, alt=alt, note=note)
