"""Tables in memory and on disk: `DIR/<table>/<run_id>.parquet`.

A run exists if and only if its file in `runs` does: that one is written last, and all readers ignore files of other
tables without it.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pyarrow as pa

from aeb_sumo.errors import InputError
from aeb_sumo.results.place import Place
from aeb_sumo.results.schema import TABLES
from aeb_sumo.results.writer import Writer

__all__ = ["Results", "commit_failure", "finished", "holds_results", "read", "write"]

if TYPE_CHECKING:  # a run does without, and it takes long to import
    import pandas as pd

_DIED = {"outcome": "failed", "end_s": None}
Rows = Iterable[Mapping[str, Any]]  # or an Arrow table, which ships no types


@dataclass(frozen=True)
class Results:
    """The tables of one or more runs.

    Attributes:
        tables: table name -> Arrow table with the schema of `TABLES`.
    """

    tables: dict[str, pa.Table]

    @classmethod
    def of(cls, rows: Mapping[str, Rows | pa.Table]) -> "Results":
        """From rows as mappings or in a table; tables without rows have their columns all the same."""
        return cls({name: _table(rows.get(name, ()), t.arrow()) for name, t in TABLES.items()})

    @classmethod
    def joined(cls, results: Iterable["Results"]) -> "Results":
        """The runs of several results together."""
        parts = list(results)
        return cls({name: pa.concat_tables([r.tables[name] for r in parts]) for name in TABLES})

    def frame(self, table: str) -> "pd.DataFrame":
        """A table as a DataFrame."""
        frame: pd.DataFrame = self.tables[table].to_pandas()
        return frame

    def __getattr__(self, name: str) -> "pd.DataFrame":
        """`results.crashes` is `results.frame("crashes")`."""
        if name in TABLES:
            return self.frame(name)
        raise AttributeError(name)


def _table(rows: Any, schema: pa.Schema) -> pa.Table:
    return rows if isinstance(rows, pa.Table) else pa.Table.from_pylist(list(rows), schema=schema)


def finished(out: str | Path) -> set[str]:
    """Ids of the runs that exist in a local folder or at an fsspec URL; none if it is not there.

    Raises:
        InputError: it cannot be listed.
    """
    return Place.of(out).runs_of("runs")


def holds_results(out: str | Path) -> bool:
    """Whether any run exists there."""
    return bool(finished(out))


def write(results: Results, out: str | Path) -> None:
    """Write the tables of one run, which is there as a whole or not at all, and takes the place of one of its id.

    Args:
        results: of one run.
        out: local folder or fsspec URL.

    Raises:
        InputError: it cannot be written to.
    """
    (run,) = results.tables["runs"].to_pylist()
    with Writer(out, run.pop("run_id")) as writer:
        for name, table in results.tables.items():
            for batch in table.drop_columns("run_id").to_batches() if name != "runs" else ():
                writer.put(name, batch)
        writer.commit(run)


def commit_failure(out: str | Path, row: Mapping[str, Any]) -> None:
    """Write down a run that died or hung: a row in `runs`, and all other tables without rows.

    Args:
        out: local folder or fsspec URL.
        row: columns of `runs`, of which `run_id` must be there; the outcome is `failed`, and no time was reached.

    Raises:
        InputError: a column does not exist, a value is of another type, or it cannot be written.
    """
    columns = [c.name for c in TABLES["runs"].columns]
    if unknown := sorted({*row} - {*columns}):
        raise InputError(f"table runs has no column {unknown[0]!r}; there are: {', '.join(columns)}")
    if "run_id" not in row:
        raise InputError("a row of runs needs its run_id")
    try:
        results = Results.of({"runs": [dict(row) | {"reason": row.get("reason") or "", **_DIED}]})
    except (pa.ArrowInvalid, pa.ArrowTypeError) as error:
        raise InputError(f"a row of runs has a value of another type: {error}") from None
    write(results, out)


def read(folder: str | Path) -> Results:
    """Read all runs of a local folder or fsspec URL into memory, in the order of their ids.

    Raises:
        InputError: there are no results, or a table cannot be read.
    """
    from aeb_sumo.results.reader import Stored  # noqa: PLC0415 - it brings pandas, and a run does without

    stored = Stored.of(folder)
    return Results({name: stored.read(name) for name in TABLES})
