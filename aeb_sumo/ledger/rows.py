"""Finished rows of a table, packed as they come, and kept or passed on, so that a long run costs little memory."""

from collections.abc import Callable, Mapping
from typing import Any

import pyarrow as pa

from aeb_sumo.results.schema import TABLES
from aeb_sumo.results.writer import of_run

__all__ = ["Rows"]

_PACK = 512  # rows


class Rows:
    """Rows of one table. A row as a dict takes some kilobytes, packed some 200 bytes.

    Args:
        table: its name in `TABLES`.
        pack: so many rows at a time, our assumption.

    They lack the column `run_id`, which `of_run` adds.
    """

    def __init__(self, table: str, *, pack: int = _PACK) -> None:
        self._table, self._size = table, pack
        self._schema: pa.Schema = TABLES[table].arrow().remove(0)
        self._put: Callable[[pa.RecordBatch], None] | None = None
        self._packed: list[pa.RecordBatch] = []
        self._loose: list[Mapping[str, Any]] = []
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def append(self, row: Mapping[str, Any]) -> None:
        """Add a finished row; it must not change afterwards."""
        self._loose.append(row)
        self._count += 1
        if len(self._loose) >= self._size:
            self._pack()

    def stream(self, put: Callable[[pa.RecordBatch], None]) -> None:
        """Pass rows on from now on, some hundred at a time, and keep none."""
        self._put = put

    def _pack(self) -> None:
        batch = pa.RecordBatch.from_pylist(self._loose, schema=self._schema)
        self._loose = []
        if self._put is None:
            self._packed.append(batch)
        else:
            self._put(batch)

    def of_run(self, run_id: str) -> pa.Table:
        """All rows that are kept, as rows of a run; the last ones are passed on where they are not kept."""
        self._pack()
        return of_run(pa.Table.from_batches(self._packed, schema=self._schema), self._table, run_id)
