"""What the traffic got through, and what the AEB changed in that."""

import pandas as pd

from analysis.load import Dataset

__all__ = ["throughput", "throughput_impact"]


def throughput(data: Dataset) -> pd.DataFrame:
    """Flow, speed and delay over whole runs, one row per group of runs.

    Returns:
        Columns `arrived` and `pending` (at the end), vehicles in all runs; `flow_vph`, arrivals per hour and run;
        `speed_kmh`, space-mean; `delay_s_per_km`, against driving at the allowed speed, per vehicle-km.
    """
    rows = {}
    for name, part in data.by_group().items():
        traffic, runs = part.traffic, part.runs
        hours = (runs["end_s"] - runs["begin_s"]).sum() / 3600
        last = traffic["end_s"] == traffic.groupby("run_id")["end_s"].transform("max")
        distance, time = traffic["distance_m"].sum(), traffic["time_s"].sum()
        rows[name] = {
            "arrived": traffic["arrived"].sum(),
            "pending": traffic.loc[last, "pending"].sum(),
            "flow_vph": traffic["arrived"].sum() / hours if hours else float("nan"),
            "speed_kmh": 3.6 * distance / time if time else float("nan"),
            "delay_s_per_km": traffic["delay_s"].sum() / (distance / 1000) if distance else float("nan"),
        }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("group")


def throughput_impact(data: Dataset, baseline: str = "none") -> pd.DataFrame:
    """Change of every figure of `throughput` against the baseline, in percent of it.

    Raises:
        KeyError: there is no group of that name.
    """
    figures = throughput(data)
    if baseline not in figures.index:
        raise KeyError(f"no group {baseline!r}; there are {', '.join(figures.index)}")
    return (figures / figures.loc[baseline] - 1).mul(100).drop(index=baseline)
