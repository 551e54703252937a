"""Tables in memory and on disk: `DIR/<table>/<run_id>.parquet`."""

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from aeb_sumo.errors import InputError
from aeb_sumo.results.schema import SCHEMA_VERSION, TABLES

__all__ = ["Results", "holds_results", "read", "write"]

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

    def frame(self, table: str) -> pd.DataFrame:
        """A table as a DataFrame."""
        frame: pd.DataFrame = self.tables[table].to_pandas()
        return frame

    def __getattr__(self, name: str) -> pd.DataFrame:
        """`results.crashes` is `results.frame("crashes")`."""
        if name in TABLES:
            return self.frame(name)
        raise AttributeError(name)


def _table(rows: Any, schema: pa.Schema) -> pa.Table:
    return rows if isinstance(rows, pa.Table) else pa.Table.from_pylist(list(rows), schema=schema)


def holds_results(folder: str | Path) -> bool:
    """Whether any table is there."""
    return any((Path(folder) / name).exists() for name in TABLES)


def write(results: Results, folder: str | Path) -> None:
    """Write the tables of one run into `folder`, each complete or not at all; `runs` comes last.

    Raises:
        InputError: the folder cannot be written.
    """
    (run_id,) = results.tables["runs"]["run_id"].to_pylist()
    try:
        for name in sorted(TABLES, key=lambda n: n == "runs"):
            target = Path(folder) / name / f"{run_id}.parquet"
            target.parent.mkdir(parents=True, exist_ok=True)
            partial = target.with_name(f".{target.name}.partial")
            pq.write_table(results.tables[name], partial)
            os.replace(partial, target)  # noqa: PTH105 - atomic
    except OSError as error:
        raise InputError(f"cannot write results into {folder}: {error.strerror or error}") from None


def read(folder: str | Path) -> Results:
    """Read all runs of a folder, in the order of their ids.

    Raises:
        InputError: the folder holds no results, or a table of it cannot be read.
    """
    folder = Path(folder)
    if not holds_results(folder):
        raise InputError(f"no results in {folder}: expected the folders {', '.join(TABLES)}")
    tables = {}
    for name, table in TABLES.items():
        schema = table.arrow()
        parts = []
        for path in sorted((folder / name).glob("*.parquet")):
            try:
                part = pq.read_table(path)
            except (OSError, pa.ArrowInvalid) as error:
                raise InputError(f"cannot read {path}: {error}") from None
            version = (part.schema.metadata or {}).get(b"schema_version", b"none").decode(errors="replace")
            if version != str(SCHEMA_VERSION) or not part.schema.equals(schema):
                raise InputError(
                    f"{path} has another schema than table {name!r} of this program: version {version} "
                    f"instead of {SCHEMA_VERSION}, or other columns; make the results again, or read them with the "
                    "aeb-sumo that made them"
                )
            parts.append(part)
        tables[name] = pa.concat_tables([schema.empty_table(), *parts])
    if not tables["runs"].num_rows:
        raise InputError(f"no runs in {folder}: its table runs is missing or empty")
    return Results(tables)
