"""Crash counts and rates."""

import pandas as pd

from analysis.load import Dataset
from analysis.rates import poisson_rate, rate_ratio

__all__ = ["crash_counts", "crash_rate_ratios", "crash_rates"]


def crash_counts(data: Dataset, by: str = "kind") -> pd.DataFrame:
    """Crashes by a column of `crashes`, one column per group of runs, and a total."""
    groups = data.by_group()
    counts = pd.DataFrame({name: part.crashes[by].value_counts() for name, part in groups.items()})
    counts = counts.reindex(columns=list(groups)).fillna(0).astype("int64").sort_index()
    counts.loc["total"] = counts.sum()
    return counts.rename_axis(index=by, columns="group")


def crash_rates(data: Dataset, confidence: float = 0.95) -> pd.DataFrame:
    """Crashes per million vehicle-km of all vehicles, with exact Poisson intervals, one row per group of runs.

    A crash counts once, though it has two vehicles. The interval takes crashes as independent; secondary crashes are
    not, so where there are many of them it is too narrow.

    Returns:
        Columns `crashes`, `vehicle_km`, `per_million_km`, `low`, `high`.
    """
    rows = {}
    for name, part in data.by_group().items():
        km = part.exposure["distance_m"].sum() / 1000
        rate = poisson_rate(len(part.crashes), km / 1e6, confidence)
        rows[name] = {
            "crashes": len(part.crashes),
            "vehicle_km": km,
            "per_million_km": rate.rate,
            "low": rate.low,
            "high": rate.high,
        }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("group")


def crash_rate_ratios(data: Dataset, baseline: str = "none", confidence: float = 0.95) -> pd.DataFrame:
    """Crash rate of every group of runs by that of the baseline, with score intervals of two Poisson rates.

    The interval takes all crashes as independent of each other and the two worlds as well. Within a pile-up they are
    not, and then it is too narrow: read the row of primary crashes. `analysis.effect` compares seed by seed instead.

    Args:
        data: runs of two or more groups.
        baseline: name of the group that the others are compared with.
        confidence: of the intervals, 0 to 1.

    Returns:
        Index (group, crashes), crashes being `all` or `primary`; columns `count`, `baseline_count`, `ratio`, `low`,
        `high`.

    Raises:
        KeyError: there is no group of that name.
    """
    groups = data.by_group()
    if baseline not in groups:
        raise KeyError(f"no group {baseline!r}; there are {', '.join(groups)}")
    distance = {name: float(part.exposure["distance_m"].sum()) for name, part in groups.items()}
    rows = []
    for name, part in groups.items():
        if name == baseline:
            continue
        for which in ("all", "primary"):
            here, there = (
                len(some) if which == "all" else int((~some["secondary"].astype(bool)).sum())
                for some in (part.crashes, groups[baseline].crashes)
            )
            found = rate_ratio(
                count=here, exposure=distance[name], baseline_count=there, baseline_exposure=distance[baseline],
                confidence=confidence,
            )  # fmt: skip
            row = {"group": name, "crashes": which, "count": here, "baseline_count": there, "ratio": found.ratio}
            rows.append(row | {"low": found.low, "high": found.high})
    columns = ["group", "crashes", "count", "baseline_count", "ratio", "low", "high"]
    return pd.DataFrame(rows, columns=columns).set_index(["group", "crashes"])
