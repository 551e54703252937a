"""Finished rows of a table, packed as they come, so that a long run costs little memory."""

from collections.abc import Mapping
from typing import Any

import pyarrow as pa

from aeb_sumo.results.schema import TABLES

__all__ = ["Rows"]

_PACK = 512  # rows


class Rows:
    """Rows of one table. A row as a dict takes some kilobytes, packed some 200 bytes.

    Args:
        table: its name in `TABLES`.

    The column `run_id` is not known before the end: `of_run` adds it.
    """

    def __init__(self, table: str) -> None:
        self._schema: pa.Schema = TABLES[table].arrow()
        self._packed: list[pa.RecordBatch] = []
        self._loose: list[Mapping[str, Any]] = []
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def append(self, row: Mapping[str, Any]) -> None:
        """Add a finished row; it must not change afterwards."""
        self._loose.append(row)
        self._count += 1
        if len(self._loose) >= _PACK:
            self._pack()

    def _pack(self) -> None:
        self._packed.append(pa.RecordBatch.from_pylist(self._loose, schema=self._schema.remove(0)))
        self._loose = []

    def of_run(self, run_id: str) -> pa.Table:
        """All rows, as rows of a run."""
        self._pack()
        table = pa.Table.from_batches(self._packed, schema=self._schema.remove(0))
        runs = pa.repeat(pa.scalar(run_id), len(table))
        return table.add_column(0, self._schema.field(0), runs).cast(self._schema)
