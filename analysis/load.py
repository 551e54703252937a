"""Loading the tables of a results folder."""

from dataclasses import dataclass, fields
from pathlib import Path

import pandas as pd

from aeb_sumo.results import Results, read

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


@dataclass(frozen=True)
class Dataset:
    """The tables of one or more runs; columns, units and meanings as in `aeb_sumo.results.TABLES`.

    Attributes:
        runs, crashes, interventions, conflicts, exposure, traffic, ceilings: DataFrames.
    """

    runs: pd.DataFrame
    crashes: pd.DataFrame
    interventions: pd.DataFrame
    conflicts: pd.DataFrame
    exposure: pd.DataFrame
    traffic: pd.DataFrame
    ceilings: pd.DataFrame

    @classmethod
    def of(cls, results: Results) -> "Dataset":
        """From results in memory."""
        return cls(**{f.name: results.frame(f.name) for f in fields(cls)})

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
        tables = {f.name: getattr(self, f.name) for f in fields(self)}
        return Dataset(**{name: table[table["run_id"].isin(run_ids)] for name, table in tables.items()})

    def by_group(self) -> dict[str, "Dataset"]:
        """One data set per group, the baseline first."""
        names = self.groups()
        order = sorted(names.unique(), key=lambda name: (name.partition(",")[0] != "none", name))
        return {name: self.only(names.index[names == name]) for name in order}


def load(folder: str | Path) -> Dataset:
    """Load a results folder.

    Raises:
        aeb_sumo.errors.InputError: it holds no results, or they cannot be read.
    """
    return Dataset.of(read(folder))
