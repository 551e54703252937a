"""Crash counts and rates."""

import pandas as pd

from analysis.load import Dataset
from analysis.rates import poisson_rate

__all__ = ["crash_counts", "crash_rates"]


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
