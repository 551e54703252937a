"""Writes the tables of one run as they come; they are a run's when all of them are there, and not before."""

import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any, Self

import pyarrow as pa
import pyarrow.parquet as pq

from aeb_sumo.errors import InputError
from aeb_sumo.results.place import SUFFIX, Place, one_line
from aeb_sumo.results.schema import TABLES

__all__ = ["ROW_GROUP", "Writer", "of_run"]

ROW_GROUP = 16384
"""Rows that are gathered before they are written: some megabytes. Few rows at a time would make large, slow files."""

_LONGEST = 230  # bytes of a run id: a file name has 255, some of them for its endings


def of_run(rows: pa.Table, table: str, run_id: str) -> pa.Table:
    """Rows of a table that lack the column `run_id`, with it."""
    schema = TABLES[table].arrow()
    return rows.add_column(0, schema.field(0), pa.repeat(pa.scalar(run_id), len(rows))).cast(schema)


class _File:
    """One table of the run on its way: a Parquet file in which rows are appended, some thousand at a time."""

    def __init__(self, path: Path, table: str, run_id: str, row_group: int) -> None:
        self.path, self._table, self._run_id, self._row_group = path, table, run_id, row_group
        path.parent.mkdir(parents=True, exist_ok=True)
        self._file: IO[bytes] = path.open("wb")
        self._parquet = pq.ParquetWriter(self._file, TABLES[table].arrow())
        self._waiting: list[pa.RecordBatch] = []
        self._count = 0

    def put(self, batch: pa.RecordBatch) -> None:
        self._waiting.append(batch)
        self._count += len(batch)
        if self._count >= self._row_group:
            self._flush()

    def _flush(self) -> None:
        if self._waiting:
            rows = pa.Table.from_batches(self._waiting)
            self._waiting, self._count = [], 0
            self._parquet.write_table(of_run(rows, self._table, self._run_id), row_group_size=self._row_group)

    def close(self) -> None:
        """All rows are there: on the disk, not only on their way to it."""
        self._flush()
        self._parquet.close()
        self._file.flush()
        os.fsync(self._file.fileno())
        self._file.close()

    def discard(self) -> None:
        """Never mind."""
        self._parquet.is_open = False  # a full disk does not take the end of the file either
        with suppress(OSError):
            self._file.close()
        self.path.unlink(missing_ok=True)


class Writer:
    """Writes the tables of one run.

    In a local folder, rows go to `<table>/.<run_id>.parquet.partial`. Elsewhere they go to a temporary folder, and from
    there to the URL when the run is over: an object is there as a whole or not at all, and no connection has to live as
    long as a run. A run of that id that is there already is replaced as a whole.

    Args:
        out: local folder or URL.
        run_id: of the run.
        row_group: so many rows are gathered before they are written, our assumption.

    As a context it discards, when left, what has not been committed.

    Raises:
        InputError: here or later: the place or the id cannot be used, or the place cannot be written to. Then nothing
            is left of the run.
    """

    def __init__(self, out: "str | os.PathLike[str]", run_id: str, *, row_group: int = ROW_GROUP) -> None:
        if not 0 < len(run_id.encode()) <= _LONGEST or run_id[0] in "._" or {*"/\0*?["} & {*run_id}:
            allowed = f"1 to {_LONGEST} bytes, no slash, *, ? or [, no dot or underscore first"
            raise InputError(f"run id {run_id!r} names no file: {allowed}")
        self._place, self.run_id = Place.of(out), run_id
        self._process = os.getpid()
        self._spool: str | None = None
        self._files: dict[str, _File] = {}
        self._open = True
        with self._reporting():
            local = self._place.local
            if local is None:
                self._spool = tempfile.mkdtemp(prefix="aeb-sumo-")
            folder = Path(self._spool or ".") if local is None else local
            for name in sorted(TABLES, key=lambda name: name == "runs"):
                path = folder / name / f".{run_id}{SUFFIX}.partial"
                self._files[name] = _File(path, name, run_id, row_group)

    def put(self, table: str, rows: pa.RecordBatch) -> None:
        """Append rows to a table.

        Args:
            table: its name in `TABLES`.
            rows: columns as there, but for `run_id`.
        """
        if os.getpid() != self._process:  # a fork of the world, whose rows are not those of the run
            return
        with self._reporting():
            self._files[table].put(rows)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.discard()

    def commit(self, run: Mapping[str, Any]) -> None:
        """The run is over, and exists from now on.

        Args:
            run: its row in `runs`, but for `run_id`.
        """
        self.put("runs", pa.RecordBatch.from_pylist([run], schema=TABLES["runs"].arrow().remove(0)))
        with self._reporting():
            for file in self._files.values():
                file.close()
            # Between two runs of one id there is none.
            self._place.remove("runs", self.run_id)
            for name, file in self._files.items():
                if self._place.local is None:
                    self._place.upload(file.path, name, self.run_id)
                else:
                    os.replace(file.path, file.path.with_name(f"{self.run_id}{SUFFIX}"))  # noqa: PTH105 - atomic
        self._open = False
        self._clear()

    def discard(self) -> None:
        """Leave nothing of a run that is not to be; without effect on one that has been committed."""
        if self._open and os.getpid() == self._process:
            self._open = False
            for file in self._files.values():
                file.discard()
            self._clear()

    def _clear(self) -> None:
        if self._spool is not None:
            shutil.rmtree(self._spool, ignore_errors=True)

    @contextmanager
    def _reporting(self) -> Iterator[None]:
        """What fails here is said in one line, and ends the run."""
        try:
            yield
        except InputError:
            self.discard()
            raise
        except OSError as error:
            self.discard()
            raise InputError(f"cannot write results into {self._place.name}: {one_line(error)}") from None
        except BaseException:
            self.discard()
            raise
