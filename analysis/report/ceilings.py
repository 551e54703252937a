"""What is physics and what is the strategy: the ceilings of the baseline's crashes."""

from collections.abc import Mapping, Sequence
from typing import Any

from analysis.ceilings import ceiling_shares, ceilings_left
from analysis.load import Dataset
from analysis.report.intervals import records
from analysis.report.matching import Match
from analysis.report.parts import Cell, Quantity, Section, Table, count

__all__ = ["section"]

_NAMES = {"perfect": "perfect sensor, full braking at once", "careful": "careful driver (UN R157)"}


def section(data: Dataset, matched: Sequence[Match]) -> Section | None:
    """Who could have avoided the crashes without AEB; None where nobody asked."""
    if data.ceilings.empty:
        return None
    shares = Table(
        id="ceiling-table", title="Crashes without AEB, and who would have avoided them",
        head=("braking by", "crashes", "avoided", "mitigated", "as hard or harder", "another crash instead"),
        rows=[_row(row) for row in records(ceiling_shares(data))],
        note="Every crash in forks of the world made 8 s before it, with one system in the motor vehicles that crash. "
        "Wilson's intervals, which take crashes as independent; those of one pile-up are not.",
    )  # fmt: skip
    left = Table(
        id="left-table", title="What the fleet left of what physics allows",
        head=("group", "crashes", "avoidable by braking", "of these avoided", "left"),
        rows=[_left(match.group, row) for match in matched if len(match.pairs) and len(match.both.ceilings)
              for row in records(ceilings_left(match.both))],
        note="The same two vehicles in the run with AEB. Most avoided crashes did not come about, as the traffic had "
        "become another one: few are left.",
    )  # fmt: skip
    text = "What perfect braking does not avoid is physics; what it avoids and the AEB does not is the strategy."
    tables = [table for table in (shares, left) if table.rows]
    return Section(id="ceilings", title="Who could have avoided it", text=[(text,)], tables=tables)


def _row(row: Mapping[str, Any]) -> list[Cell]:
    key, known = f"ceilings/{row['ceiling']}", row["crashes"] - row["unknown"]
    avoided = Quantity(
        key=f"{key}/avoided", value=row["percent"], low=row["low"], high=row["high"], n=known, of="crashes", unit="%"
    )
    counts = {"mitigated": row["mitigated"], "not": row["unchanged"] + row["worsened"], "other": row["other"]}
    others = [count(f"{key}/{name}", value) for name, value in counts.items()]
    return [_NAMES.get(row["ceiling"], row["ceiling"]), count(f"{key}/crashes", row["crashes"]), avoided, *others]


def _left(group: str, row: Mapping[str, Any]) -> list[Cell]:
    names = ("crashes", "avoidable", "avoided", "left")
    return [group, *(count(f"{group}/ceilings/{name}", row[name]) for name in names)]
