"""The tables of a results folder, in memory or read as they are asked for."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, ClassVar

import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc

from aeb_sumo.errors import InputError
from aeb_sumo.results import TABLES, Results
from aeb_sumo.results.filters import Filters, chosen, expression, names_of
from aeb_sumo.results.reader import Stored

__all__ = ["Dataset", "load"]


_SETTINGS = (
    "scenario",
    "demand",
    "ebike_share",
    "weather",
    "penetration",
    "sensing",
    "parameters",
    "drivers",
    "step_length_s",
    "mu",
    "blockage_s",
)


def _frame(table: Any) -> pd.DataFrame:
    """An Arrow table that nobody else needs, column by column, so that it does not take its memory twice."""
    frame: pd.DataFrame = table.to_pandas(split_blocks=True, self_destruct=True)
    return frame


def _told_apart(runs: Any) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Runs that left something, and those that died, which an Arrow table holds."""
    died = pc.and_(pc.fill_null(pc.equal(runs["outcome"], "failed"), False), pc.is_null(runs["end_s"]))
    return _frame(runs.filter(pc.invert(died))), _frame(runs.filter(died))


@dataclass(frozen=True, repr=False, eq=False)
class Dataset:
    """The tables of one or more runs; columns, units and meanings as in `aeb_sumo.results.TABLES`.

    Those of a folder are read when they are first asked for. `read` reads some columns and rows of one.

    Attributes:
        runs, crashes, interventions, conflicts, exposure, traffic, ceilings: DataFrames.
        died: rows of `runs` of those that died or hung before they could write down anything; they are not in `runs`,
            so that they are no runs without crashes.
    """

    runs: pd.DataFrame
    crashes: pd.DataFrame
    interventions: pd.DataFrame
    conflicts: pd.DataFrame
    exposure: pd.DataFrame
    traffic: pd.DataFrame
    ceilings: pd.DataFrame

    died: ClassVar[pd.DataFrame] = _frame(TABLES["runs"].arrow().empty_table())
    _stored: ClassVar[Stored | None] = None  # where tables are that have not been read

    @classmethod
    def of(cls, results: Results) -> "Dataset":
        """From results in memory."""
        runs, died = _told_apart(results.tables["runs"])
        data = cls(runs=runs, **{f.name: results.frame(f.name) for f in fields(cls) if f.name != "runs"})
        data.__dict__["died"] = died
        return data

    @classmethod
    def of_stored(cls, stored: Stored, **tables: pd.DataFrame) -> "Dataset":
        """From a folder, of which some tables have been read."""
        data = cls.__new__(cls)
        data.__dict__.update(tables, _stored=stored)
        return data

    def __getattr__(self, name: str) -> pd.DataFrame:
        """A table that has not been read."""
        if self._stored is None or name not in TABLES:
            raise AttributeError(f"{type(self).__name__!r} has no attribute {name!r}")
        frame = self.__dict__[name] = _frame(self._stored.read(name))
        return frame

    def read(self, table: str, columns: Sequence[str] | None = None, filters: Filters | None = None) -> pd.DataFrame:
        """Some columns and rows of a table; what else is in it takes no memory.

        Args:
            table: its name in `TABLES`.
            columns: their names, None for all.
            filters: which rows, for example `[("phase", "!=", "warn"), ("target_vclass", "in", ["bicycle"])]`, as in
                `aeb_sumo.results.filters`; None for all.

        Raises:
            InputError: there is no such table or column, a filter is none, or a file cannot be read.
        """
        names, rows = chosen(table, columns), expression(table, filters)
        if self._stored is not None and table not in self.__dict__:
            return _frame(self._stored.read(table, columns=columns, filters=filters))
        frame: pd.DataFrame = getattr(self, table)
        if rows is not None:
            schema = TABLES[table].arrow()
            looked = pa.Table.from_pandas(
                frame, pa.schema([schema.field(name) for name in names_of(filters)]), preserve_index=False
            )
            where = looked.append_column("", pa.array(range(len(frame)), pa.int64())).filter(rows)[""]
            frame = frame.iloc[where.to_numpy()]
        return frame[names]

    def count(self, table: str) -> int:
        """Rows of a table, which is not read for it."""
        if self._stored is not None and table not in self.__dict__:
            return self._stored.count(table)
        return len(self.read(table))

    def groups(self) -> pd.Series:
        """Group of every run, by run id: runs of one group differ in seed and time span alone.

        A group is named by its strategy, or the text of its mix, by its scenario, if there are several, and by whatever
        else differs between the runs of that scenario; sensing and parameters, between those of that strategy.
        """
        runs = self.runs.set_index("run_id")
        names = runs["strategy"].astype(str)
        # A share of nothing is no difference, and a mix says its shares itself.
        single = (names != "none") & ~names.str.contains("=", regex=False)
        for column in _SETTINGS:
            values = runs[column].map(str).replace("", "default")
            if column in {"sensing", "parameters"}:
                rows = values.groupby(runs["strategy"]).transform("nunique") > 1
            else:
                rows = single if column == "penetration" else pd.Series(True, index=runs.index)
                within = [True] * len(runs) if column == "scenario" else runs["scenario"]
                rows &= values.where(rows).groupby(within).transform("nunique") > 1
            names = names.where(~rows, names + f", {column} " + values)
        return names.rename("group")

    def only(self, run_ids: pd.Index) -> "Dataset":
        """The tables of some runs."""
        if self._stored is not None:
            stored = self._stored.only(set(run_ids))
            known = {name: frame for name, frame in self.__dict__.items() if name in TABLES}
            some = {name: frame[frame["run_id"].isin(run_ids)] for name, frame in known.items()}
            return self if stored == self._stored else Dataset.of_stored(stored, **some)
        tables = {f.name: getattr(self, f.name) for f in fields(self)}
        return Dataset(**{name: table[table["run_id"].isin(run_ids)] for name, table in tables.items()})

    def by_group(self) -> dict[str, "Dataset"]:
        """One data set per group, the baseline first; those of a folder are the same at every call, and read once."""
        if "_groups" in self.__dict__:
            return dict(self.__dict__["_groups"])
        names = self.groups()
        order = sorted(names.unique(), key=lambda name: (name.partition(",")[0] != "none", name))
        groups = {name: self.only(names.index[names == name]) for name in order}
        if self._stored is not None:
            self.__dict__["_groups"] = groups
        return dict(groups)


def load(folder: str | Path, *, filters: Filters | None = None) -> Dataset:
    """Runs of a results folder, whose tables are read when they are asked for.

    Args:
        folder: a local one, or an fsspec URL such as `s3://bucket/study`.
        filters: which runs, by columns of `runs`, for example `[("strategy", "==", "zhao2025"), ("seed", "<", 5)]`, as
            in `aeb_sumo.results.filters`; None for all. The files of other runs are not opened.

    Raises:
        InputError: it holds no results, a filter is none or leaves no run, or a table cannot be read.
    """
    stored = Stored.of(folder)
    runs, died = _told_apart(stored.read("runs", filters=filters))
    if runs.empty and died.empty:
        raise InputError(f"no run in {folder} matches {filters!r}")
    if runs.empty:
        raise InputError(f"all {len(died)} runs in {folder} died: {', '.join(sorted(set(died['reason'])))}")
    return Dataset.of_stored(stored.only(runs["run_id"]), runs=runs, died=died)
