"""Analysis of aeb-sumo's tables, pandas in and out. Needs no SUMO.

data = analysis.load("results")   # or a URL, and some runs: filters=[("strategy", "==", "zhao2025")]
data.crashes                      # one of the tables, a DataFrame, read when it is asked for
data.read("interventions", ["strategy", "verdict"], [("phase", "!=", "warn")])  # some columns and rows of one
analysis.summary(data)            # everything at a glance, one column per group of runs
"""

from analysis.ceilings import ceiling_shares, ceilings_left
from analysis.compare import compare, summary
from analysis.conflicts import conflict_counts, conflict_statistics, near_crash_ratio
from analysis.crashes import crash_counts, crash_rate_ratios, crash_rates
from analysis.effect import effect, figures_by_seed, run_figures
from analysis.interventions import intervention_counts, intervention_statistics
from analysis.load import Dataset, load
from analysis.outcomes import mcnemar_test, pair_counts
from analysis.pairs import pairs, partners
from analysis.planning import events_needed, exposure_without_events, planning, seeds_needed
from analysis.price import delay_per_avoided_crash, traffic_price
from analysis.rates import poisson_rate, rate_ratio
from analysis.shares import proportion, share_by_seed
from analysis.statistics import Interval, paired_interval
from analysis.throughput import throughput, throughput_impact, throughput_over_time
from analysis.verdicts import passed_on, precision_recall, verdict_counts, verdict_rates

__all__ = [
    "Dataset",
    "Interval",
    "ceiling_shares",
    "ceilings_left",
    "compare",
    "conflict_counts",
    "conflict_statistics",
    "crash_counts",
    "crash_rate_ratios",
    "crash_rates",
    "delay_per_avoided_crash",
    "effect",
    "events_needed",
    "exposure_without_events",
    "figures_by_seed",
    "intervention_counts",
    "intervention_statistics",
    "load",
    "mcnemar_test",
    "near_crash_ratio",
    "pair_counts",
    "paired_interval",
    "pairs",
    "partners",
    "passed_on",
    "planning",
    "poisson_rate",
    "precision_recall",
    "proportion",
    "rate_ratio",
    "run_figures",
    "seeds_needed",
    "share_by_seed",
    "summary",
    "throughput",
    "throughput_impact",
    "throughput_over_time",
    "traffic_price",
    "verdict_counts",
    "verdict_rates",
]
