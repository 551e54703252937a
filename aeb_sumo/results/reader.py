"""Reads tables of a folder of runs: some columns, some rows, of some runs, without touching the rest."""

from collections.abc import Collection, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.dataset as ds
import pyarrow.fs as pafs
import pyarrow.parquet as pq

from aeb_sumo.errors import InputError
from aeb_sumo.results.filters import Filters, chosen, expression, table_of
from aeb_sumo.results.place import Place, one_line
from aeb_sumo.results.schema import SCHEMA_VERSION, TABLES

__all__ = ["Stored"]

_AT_ONCE = 16  # threads that wait for files, our assumption; far away it is the waiting that takes the time
_FORMAT = ds.ParquetFileFormat()
_FILES = 256  # at a time: what is known of a file that has been opened takes 0.2 MB


@dataclass(frozen=True)
class Stored:
    """Runs on disk, or at a URL.

    Attributes:
        place: where.
        run_ids: which, in the order in which they are read.
    """

    place: Place
    run_ids: tuple[str, ...] = field(repr=False)

    @classmethod
    def of(cls, folder: "str | Path") -> "Stored":
        """All runs of a local folder or a URL, in the order of their ids.

        Raises:
            InputError: there are none, or the folder cannot be listed.
        """
        place = Place.of(folder)
        run_ids = place.runs_of("runs")
        if not run_ids:
            raise InputError(
                f"no results in {place.name}: expected the folders {', '.join(TABLES)}, and in runs a file per run"
            )
        return cls(place, tuple(sorted(run_ids)))

    def only(self, run_ids: Collection[str]) -> "Stored":
        """Some of the runs."""
        wanted = set(run_ids)
        return Stored(self.place, tuple(run for run in self.run_ids if run in wanted))

    def read(self, table: str, *, columns: Sequence[str] | None = None, filters: Filters | None = None) -> pa.Table:
        """Rows of a table, run by run, in the order in which they were written.

        Args:
            table: its name in `TABLES`.
            columns: that are read; None for all.
            filters: which rows, see `aeb_sumo.results.filters`; None for all.

        Raises:
            InputError: there is no such table or column, a filter is none, or a file is missing, cannot be read or is
                of another version.
        """
        schema = table_of(table).arrow()
        names = chosen(table, columns)
        rows = expression(table, filters)
        parts = [schema.empty_table().select(names)]
        if table == "runs":
            runs = self._runs()
            parts.append((runs if rows is None else runs.filter(rows)).select(names))
        for files in self._files(table) if table != "runs" else ():
            with self._reporting(files, table):
                parts.append(files.to_table(columns=names, filter=rows))
        return pa.concat_tables(parts).cast(pa.schema([schema.field(n) for n in names], metadata=schema.metadata))

    def _runs(self) -> pa.Table:
        """Table `runs`. Its files have a row each, and are read in half the time without the help of a data set."""
        with ThreadPoolExecutor(_AT_ONCE) as pool:
            parts = list(pool.map(self._run, self.run_ids))
        return pa.concat_tables([TABLES["runs"].arrow().empty_table(), *parts]).combine_chunks()

    def _run(self, run_id: str) -> pa.Table:
        path = self.place.path("runs", run_id)
        try:
            with self._filesystem.open_input_file(path) as file:
                row = pq.ParquetFile(file, pre_buffer=False).read(use_threads=False)
        except (OSError, pa.ArrowException) as error:
            raise InputError(f"cannot read {path}: {one_line(error)}") from None
        _check(row.schema, path, "runs")
        return row

    def count(self, table: str) -> int:
        """Rows of a table, which are not read for it.

        Raises:
            InputError: as `read`.
        """
        count = 0
        for files in self._files(table):
            with self._reporting(files, table):
                count += files.count_rows()
        return count

    def _files(self, table: str) -> Iterator[Any]:
        """Files of a table, some at a time."""
        schema = table_of(table).arrow()
        for first in range(0, len(self.run_ids), _FILES):
            paths = [self.place.path(table, run) for run in self.run_ids[first : first + _FILES]]
            yield ds.FileSystemDataset.from_paths(paths, schema=schema, format=_FORMAT, filesystem=self._filesystem)

    @cached_property
    def _filesystem(self) -> Any:
        if self.place.local is not None:
            return pafs.LocalFileSystem()
        return pafs.PyFileSystem(pafs.FSSpecHandler(self.place.fs))

    @contextmanager
    def _reporting(self, files: Any, table: str) -> Iterator[None]:
        """Look at the files' versions afterwards, when that costs nothing, and first if they cannot be read."""
        try:
            yield
        except (OSError, pa.ArrowException) as error:
            self._check(files, table)
            raise InputError(f"cannot read table {table} of {self.place.name}: {one_line(error)}") from None
        self._check(files, table)

    def _check(self, files: Any, table: str) -> None:
        for file in files.get_fragments():
            try:
                there = file.physical_schema
            except (OSError, pa.ArrowException) as error:
                raise InputError(f"cannot read {file.path}: {one_line(error)}") from None
            _check(there, file.path, table)


def _check(schema: pa.Schema, path: str, table: str) -> None:
    """A file is of this version."""
    version = (schema.metadata or {}).get(b"schema_version", b"none").decode(errors="replace")
    if version != str(SCHEMA_VERSION) or not schema.equals(TABLES[table].arrow()):
        raise InputError(
            f"{path} has another schema than table {table!r} of this program: version {version} instead of "
            f"{SCHEMA_VERSION}, or other columns; make the results again, or read them with the aeb-sumo that made them"
        )
