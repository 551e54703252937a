"""Which run is compared with which: the baseline of every group, seed by seed."""

from dataclasses import dataclass

import pandas as pd

from analysis.load import Dataset

__all__ = ["Match", "is_baseline", "matches"]

# A baseline has no AEB: what is said of the AEB is no difference.
_SAME = (
    "scenario", "seed", "drivers", "step_length_s", "begin_s", "end_s", "demand", "ebike_share", "weather", "mu",
    "blockage_s",
)  # fmt: skip


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


def is_baseline(group: str) -> bool:
    """Whether the runs of a group have no AEB."""
    return group.partition(",")[0] == "none"


def matches(data: Dataset) -> list[Match]:
    """Every group with AEB, in the order of `Dataset.by_group`; only completed runs of equal time span pair."""
    runs = data.runs.assign(group=data.runs["run_id"].map(data.groups()))
    done = runs[runs["outcome"] == "completed"]
    base = done[done["strategy"] == "none"]
    result = []
    for name, part in data.by_group().items():
        if is_baseline(name):
            continue
        own = done[done["group"] == name]
        pairs = own.merge(base.drop_duplicates(list(_SAME)), on=list(_SAME), suffixes=("", "_baseline"))
        pairs = pairs.rename(columns={"run_id_baseline": "baseline", "run_id": "run"})
        left = tuple(r for r in part.runs["run_id"] if r not in set(pairs["run"]))
        pairs = pairs[["seed", "baseline", "run"]].sort_values(["seed", "run"], ignore_index=True)
        both = data.only(pd.Index([*pairs["baseline"].unique(), *pairs["run"]]))
        result.append(Match(name, pairs, both, left))
    return result
