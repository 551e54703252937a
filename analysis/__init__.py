"""Analysis of aeb-sumo's tables, pandas in and out. Needs no SUMO.

data = analysis.load("results")
data.crashes                      # one of the tables, a DataFrame
analysis.summary(data)            # everything at a glance, one column per group of runs
"""

from analysis.compare import compare, summary
from analysis.conflicts import conflict_counts, conflict_statistics, near_crash_ratio
from analysis.crashes import crash_counts, crash_rates
from analysis.interventions import intervention_counts, intervention_statistics
from analysis.load import Dataset, load
from analysis.price import delay_per_avoided_crash, traffic_price
from analysis.rates import poisson_rate
from analysis.statistics import Interval, paired_interval
from analysis.throughput import throughput, throughput_impact, throughput_over_time

__all__ = [
    "Dataset",
    "Interval",
    "compare",
    "conflict_counts",
    "conflict_statistics",
    "crash_counts",
    "crash_rates",
    "delay_per_avoided_crash",
    "intervention_counts",
    "intervention_statistics",
    "load",
    "near_crash_ratio",
    "paired_interval",
    "poisson_rate",
    "summary",
    "throughput",
    "throughput_impact",
    "throughput_over_time",
    "traffic_price",
]
