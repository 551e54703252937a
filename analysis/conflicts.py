"""Conflicts: counts, distributions, and how many near-crashes there are for a crash."""

import numpy as np
import pandas as pd
from scipy.stats import beta

from analysis.load import Dataset

__all__ = ["conflict_counts", "conflict_statistics", "near_crash_ratio"]

_STATISTICS = ("min_ttc_s", "min_ttc2_s", "pet_s", "max_drac_mps2", "max_required_decel_mps2", "exposed_s")
_QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)


def conflict_counts(data: Dataset, by: str | list[str] = "kind") -> pd.DataFrame:
    """Conflicts by one or more columns of `conflicts`, one column per group of runs."""
    groups, columns = data.by_group(), [by] if isinstance(by, str) else by
    counts = pd.DataFrame({name: part.read("conflicts", columns)[by].value_counts() for name, part in groups.items()})
    return counts.reindex(columns=list(groups)).fillna(0).astype("int64").sort_index().rename_axis(columns="group")


def conflict_statistics(data: Dataset) -> pd.DataFrame:
    """Distributions of the measures of criticality, by group of runs and kind of conflict; crashes are left out.

    Returns:
        Index (group, kind, measure); columns `count`, of the conflicts that have a finite value, and its quantiles.
    """
    rows = []
    for name, part in data.by_group().items():
        conflicts = part.read("conflicts", ["kind", "crashed", *_STATISTICS])
        for kind, some in conflicts[~conflicts["crashed"].astype(bool)].groupby("kind"):
            for measure in _STATISTICS:
                values = some[measure].replace([np.inf, -np.inf], np.nan).dropna()
                row = {"group": name, "kind": kind, "measure": measure, "count": len(values)}
                rows.append(row | {f"{q:.0%}": values.quantile(q) for q in _QUANTILES})
    columns = ["group", "kind", "measure", "count", *(f"{q:.0%}" for q in _QUANTILES)]
    return pd.DataFrame(rows, columns=columns).set_index(["group", "kind", "measure"])


def near_crash_ratio(data: Dataset, confidence: float = 0.95) -> pd.DataFrame:
    """Primary rear-end near-crashes per primary rear-end crash, one row per group of runs.

    The interval takes both as Poisson: given their sum, the share of crashes is binomial (Clopper and Pearson 1934).
    For comparison: 761 near-crashes and 82 crashes of all kinds in the 100-Car study, 9.3 : 1.

    Returns:
        Columns `near_crashes`, `crashes`, `ratio`, `low`, `high`; the ratio is `inf` without crashes and NaN without
        either.
    """
    rows = {}
    for name, part in data.by_group().items():
        conflicts = part.read("conflicts", ["kind", "secondary", "near_crash"])
        primary = conflicts[~conflicts["secondary"].astype(bool) & (conflicts["kind"] == "following")]
        near = int(primary["near_crash"].sum())
        crashes = int(((part.crashes["kind"] == "rear_end") & ~part.crashes["secondary"].astype(bool)).sum())
        tail = (1 - confidence) / 2
        low = beta.ppf(tail, near, crashes + 1) if near else 0.0
        high = beta.ppf(1 - tail, near + 1, crashes) if crashes else 1.0
        rows[name] = {
            "near_crashes": near,
            "crashes": crashes,
            "ratio": near / crashes if crashes else np.inf if near else np.nan,
            "low": low / (1 - low),
            "high": high / (1 - high) if high < 1 else np.inf,
        }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("group")
