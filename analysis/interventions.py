"""Intervention counts and statistics."""

import numpy as np
import pandas as pd

from analysis.load import Dataset
from analysis.rates import poisson_rate

__all__ = ["intervention_counts", "intervention_statistics"]

_BY = ["phase", "target_kind"]
_STATISTICS = ("trigger_ttc_s", "max_decel_mps2", "speed_reduction_mps")


def _equipped_km(part: Dataset) -> float:
    return float(part.exposure.loc[part.exposure["equipped"], "distance_m"].sum() / 1000)


def intervention_counts(data: Dataset, by: str | list[str] = "phase") -> pd.DataFrame:
    """Interventions by one or more columns of `interventions`, one column per group of runs."""
    groups = data.by_group()
    counts = pd.DataFrame({name: part.interventions[by].value_counts() for name, part in groups.items()})
    return counts.reindex(columns=list(groups)).fillna(0).astype("int64").sort_index().rename_axis(columns="group")


def intervention_statistics(data: Dataset, confidence: float = 0.95) -> pd.DataFrame:
    """Count, rate and size of interventions by group of runs, phase and kind of target.

    Returns:
        Index (group, phase, target_kind); columns `count`; `per_1000_km` of the equipped vehicles with its exact
        Poisson interval `low`, `high`; and the mean and median of `trigger_ttc_s` (finite ones only),
        `max_decel_mps2` and `speed_reduction_mps`.
    """
    rows = []
    for name, part in data.by_group().items():
        km = _equipped_km(part)
        for (phase, kind), some in part.interventions.groupby(_BY):
            rate = poisson_rate(len(some), km / 1000, confidence)
            row = {"group": name, "phase": phase, "target_kind": kind, "count": len(some)}
            row |= {"per_1000_km": rate.rate, "low": rate.low, "high": rate.high}
            for column in _STATISTICS:
                values = some[column].replace([np.inf, -np.inf], np.nan)
                row |= {f"{column}_mean": values.mean(), f"{column}_median": values.median()}
            rows.append(row)
    columns = ["group", *_BY, "count", "per_1000_km", "low", "high"]
    columns += [f"{c}_{s}" for c in _STATISTICS for s in ("mean", "median")]
    return pd.DataFrame(rows, columns=columns).set_index(["group", *_BY])
