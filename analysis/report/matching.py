"""Which run is compared with which: the baseline of every group, seed by seed."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import pandas as pd

from analysis.effect import effect
from analysis.load import Dataset
from analysis.pairs import SAME
from analysis.price import traffic_price
from analysis.report.intervals import records

__all__ = ["Match", "is_baseline", "matches"]


@dataclass(frozen=True)
class Match:
    """A group of runs with AEB, and the runs without that it is compared with.

    Attributes:
        group: its name.
        pairs: one row per seed: `seed`, `baseline` and `run`, the ids of the two runs.
        both: the tables of these runs.
        left_out: runs of the group that have no completed counterpart of the same time span.
    """

    group: str
    pairs: pd.DataFrame
    both: Dataset
    left_out: tuple[str, ...]

    @cached_property
    def effect(self) -> list[dict[str, Any]]:
        """Rows of `analysis.effect`."""
        return records(effect(self.both))

    @cached_property
    def price(self) -> list[dict[str, Any]]:
        """Rows of `analysis.traffic_price`."""
        return records(traffic_price(self.both))


def is_baseline(group: str) -> bool:
    """Whether the runs of a group have no AEB."""
    return group.partition(",")[0] == "none"


def matches(data: Dataset, groups: Mapping[str, Dataset]) -> list[Match]:
    """Every group with AEB, in the order of `groups`; only completed runs of equal time span pair.

    Args:
        data: all runs.
        groups: `data.by_group()`.
    """
    done = data.runs[data.runs["outcome"] == "completed"]
    base = done[done["strategy"] == "none"]
    result = []
    for name, part in groups.items():
        if is_baseline(name):
            continue
        own = part.runs[part.runs["outcome"] == "completed"]
        pairs = own.merge(base.drop_duplicates(list(SAME)), on=list(SAME), suffixes=("", "_baseline"))
        pairs = pairs.rename(columns={"run_id_baseline": "baseline", "run_id": "run"})
        left = tuple(r for r in part.runs["run_id"] if r not in set(pairs["run"]))
        pairs = pairs[["seed", "baseline", "run"]].sort_values(["seed", "run"], ignore_index=True)
        both = data.only(pd.Index([*pairs["baseline"].unique(), *pairs["run"]]))
        result.append(Match(name, pairs, both, left))
    return result
