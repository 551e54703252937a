"""Crash by crash: what became of the baseline's crashes."""

from collections.abc import Sequence

from analysis.outcomes import pair_counts
from analysis.report.intervals import of_row, records
from analysis.report.matching import Match
from analysis.report.parts import Cell, Section, Table, count

__all__ = ["section"]


def section(matched: Sequence[Match]) -> Section | None:
    """Pairs of the same two vehicles, by outcome; None where nothing is compared."""
    compared = [m for m in matched if len(m.pairs)]
    if not compared:
        return None
    title = "Crash by crash"
    if not any(len(m.both.crashes) for m in compared):
        return Section(id="pairs", title=title, text=[("There was no crash in the runs that are compared.",)])
    table = Table(
        id="pair-table", title="What became of the crashes without AEB", rows=[r for m in compared for r in _rows(m)],
        head=(
            "group", "outcome with AEB", "crashes", "of these primary", "an AEB of them acted", "none did",
            "of the crashes without",
        ),
        note="Primary: neither vehicle had crashed before. An AEB of them acted: of one of the two, from 15 s before "
        "to 5 s after the crash without; where none did, the traffic had become another one. New crashes are counted "
        "beside those without, so they may be above 100 %. Intervals: the seed is the cluster.",
    )  # fmt: skip
    text = (
        "Every crash without AEB is looked up in the run with it: the same two vehicles, same seed. Harder or less "
        "hard: by the risk of serious injury where there is a curve for it, else by impact speed; up to 1 km/h is "
        "no change.",
    )
    return Section(id="pairs", title=title, text=[text], tables=[table])


def _rows(match: Match) -> list[list[Cell]]:
    rows: list[list[Cell]] = []
    for row in records(pair_counts(match.both)):
        key = f"{match.group}/pairs/{row['outcome']}"
        counts = [count(f"{key}/{name}", row[name]) for name in ("count", "primary")]
        how: list[Cell] = ["–", "–"]
        if row["outcome"] == "avoided":
            how = [count(f"{key}/{name}", row[name]) for name in ("intervened", "diverged")]
        rows.append([match.group, row["outcome"], *counts, *how, of_row(f"{key}/percent", row, "percent", unit="%")])
    return rows
