"""What the traffic got through, and what the AEB changed in that."""

import numpy as np
import pandas as pd
from scipy.stats import t as student

from analysis.load import Dataset

__all__ = ["throughput", "throughput_impact", "throughput_over_time"]


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


def throughput_over_time(data: Dataset, confidence: float = 0.95) -> pd.DataFrame:
    """Flow, speed, vehicles and delay by interval: means over the seeds, with t intervals of these means.

    Vehicles of all classes together. What the seeds have in common, such as the network filling up, is no part of the
    band; between two groups of the same seeds the differences are surer than bands that overlap suggest
    (`analysis.traffic_price`).

    Returns:
        Index (group, begin_s, end_s), seconds since the begin of the run, in the order of groups and time; columns
        `seeds` (runs that lasted until then), and for each of `flow_vph` (arrivals per hour), `speed_kmh` (space-mean;
        over the runs with vehicles), `vehicles` (on the road) and `delay_share` (delay by time on the road, the same)
        the mean and, by `_low` and `_high`, its bounds, which are NaN with one seed.
    """
    parts = []
    for name, part in data.by_group().items():
        rows = part.traffic.merge(part.runs[["run_id", "begin_s"]], on="run_id", suffixes=("", "_of_run"))
        span = ["begin_s", "end_s"]
        rows[span] = rows[span].sub(rows["begin_s_of_run"], axis=0).round(3)
        sums = rows.groupby(["run_id", *span])[["arrived", "distance_m", "time_s", "delay_s"]].sum()
        lasted = (part.runs["end_s"] - part.runs["begin_s"]).set_axis(part.runs["run_id"])
        # As long as nobody is there, an interval has no row.
        spans = sorted(set(zip(rows["begin_s"], rows["end_s"], strict=True)))
        every = [(run, *each) for run in lasted.index for each in spans if each[1] <= lasted[run] + 1e-3]
        index = pd.MultiIndex.from_frame(pd.DataFrame(every, columns=["run_id", *span]))
        sums = sums.reindex(index, fill_value=0.0)
        length = sums.index.get_level_values("end_s") - sums.index.get_level_values("begin_s")
        figures = pd.DataFrame({"flow_vph": sums["arrived"] / length * 3600})
        some = sums["time_s"].where(sums["time_s"] > 0)
        figures["speed_kmh"] = sums["distance_m"] / some * 3.6
        figures["vehicles"] = sums["time_s"] / length
        figures["delay_share"] = sums["delay_s"] / some
        parts.append(pd.concat({name: _banded(figures, confidence)}, names=["group"]))
    return pd.concat(parts)


def _banded(figures: pd.DataFrame, confidence: float) -> pd.DataFrame:
    """Means of all columns over runs, with t intervals."""
    each = figures.groupby(level=["begin_s", "end_s"])
    mean, count, error = each.mean(), each.count(), each.sem()
    half = error * student.ppf((1 + confidence) / 2, np.maximum(count - 1, 1))
    table = {"seeds": each.size()}
    for name in mean.columns:
        table |= {name: mean[name], f"{name}_low": mean[name] - half[name], f"{name}_high": mean[name] + half[name]}
    return pd.DataFrame(table)
