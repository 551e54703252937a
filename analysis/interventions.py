"""Intervention counts and statistics."""

import numpy as np
import pandas as pd

from analysis.load import Dataset
from analysis.rates import poisson_rate

__all__ = ["equipped_km", "intervention_counts", "intervention_statistics"]

_BY = ["strategy", "phase", "target_kind"]
_STATISTICS = ("trigger_ttc_s", "max_decel_mps2", "speed_reduction_mps")


def equipped_km(part: Dataset) -> pd.Series:
    """Distance driven by the vehicles with an AEB, by the name of its system [km]."""
    exposure = part.exposure[part.exposure["equipped"]]
    return exposure.groupby("strategy")["distance_m"].sum() / 1000


def intervention_counts(data: Dataset, by: str | list[str] = "phase") -> pd.DataFrame:
    """Interventions by one or more columns of `interventions`, one column per group of runs."""
    groups, columns = data.by_group(), [by] if isinstance(by, str) else by
    counts = pd.DataFrame(
        {name: part.read("interventions", columns)[by].value_counts() for name, part in groups.items()}
    )
    return counts.reindex(columns=list(groups)).fillna(0).astype("int64").sort_index().rename_axis(columns="group")


def intervention_statistics(data: Dataset, confidence: float = 0.95) -> pd.DataFrame:
    """Count, rate and size of interventions by group of runs, system, phase and kind of target.

    Returns:
        Index (group, strategy, phase, target_kind), strategy as in `interventions`; columns `count`; `per_1000_km` of
        the vehicles with that system with its exact Poisson interval `low`, `high`; and the mean and median of
        `trigger_ttc_s` (finite ones only), `max_decel_mps2` and `speed_reduction_mps`.
    """
    rows = []
    for name, part in data.by_group().items():
        km = equipped_km(part)
        for (system, phase, kind), some in part.read("interventions", [*_BY, *_STATISTICS]).groupby(_BY):
            rate = poisson_rate(len(some), km.get(system, 0.0) / 1000, confidence)
            row = {"group": name, "strategy": system, "phase": phase, "target_kind": kind, "count": len(some)}
            row |= {"per_1000_km": rate.rate, "low": rate.low, "high": rate.high}
            for column in _STATISTICS:
                values = some[column].replace([np.inf, -np.inf], np.nan)
                row |= {f"{column}_mean": values.mean(), f"{column}_median": values.median()}
            rows.append(row)
    columns = ["group", *_BY, "count", "per_1000_km", "low", "high"]
    columns += [f"{c}_{s}" for c in _STATISTICS for s in ("mean", "median")]
    return pd.DataFrame(rows, columns=columns).set_index(["group", *_BY])
