"""What an AEB changes, figure by figure, against the baseline of the same seeds."""

from dataclasses import replace

import numpy as np
import pandas as pd

from analysis.load import Dataset
from analysis.pairs import partners
from analysis.rates import rate_ratio
from analysis.statistics import POISSON, Interval, paired_interval

__all__ = ["effect", "figures_by_seed", "run_figures"]

# Figure, unit, what is summed, what it is counted over.
_FIGURES = (
    ("crashes", "1/run", "crashes", "runs"),
    ("primary crashes", "1/run", "primary_crashes", "runs"),
    ("expected deaths", "1/run", "deaths", "runs"),
    ("expected seriously injured", "1/run", "serious", "runs"),
    ("delay", "s/km", "delay_s", "km"),
    ("flow", "1/h", "arrived", "hours"),
    ("mean speed", "km/h", "km", "vehicle_hours"),
)


_OF_TRAFFIC = ["run_id", "distance_m", "time_s", "delay_s", "arrived"]


def run_figures(data: Dataset) -> pd.DataFrame:
    """What figures are made of, per run.

    Returns:
        Index `run_id`; columns `runs` (1), `crashes`, `primary_crashes`, `deaths` and `serious` (sums of the risks,
        lower bounds, as not everybody has a curve), `km`, `vehicle_hours` and `delay_s` of all vehicles, `arrived`, and
        `hours` simulated.
    """
    runs = data.runs.set_index("run_id")
    crashes, traffic = data.crashes, data.read("traffic", _OF_TRAFFIC).groupby("run_id")
    of_run = crashes.groupby("run_id")
    table = pd.DataFrame(index=runs.index)
    table["runs"] = 1.0
    table["crashes"] = of_run.size()
    table["primary_crashes"] = (~crashes["secondary"].astype(bool)).groupby(crashes["run_id"]).sum()
    for name, what in (("deaths", "death"), ("serious", "serious")):
        table[name] = of_run[[f"striker_{what}_risk", f"struck_{what}_risk"]].sum().sum(axis=1)
    table["km"] = traffic["distance_m"].sum() / 1000
    table["vehicle_hours"] = traffic["time_s"].sum() / 3600
    table["delay_s"] = traffic["delay_s"].sum()
    table["arrived"] = traffic["arrived"].sum()
    table["hours"] = (runs["end_s"] - runs["begin_s"]) / 3600
    return table.fillna(0.0).astype(float)


def figures_by_seed(data: Dataset, baseline: str = "none") -> dict[str, tuple[pd.DataFrame, pd.DataFrame]]:
    """`run_figures` of the baseline and of every group with AEB, in the same order of seeds.

    Returns:
        Group -> (baseline, with AEB), index `seed`; runs of one seed are summed.

    Raises:
        InputError: as `partners`.
    """
    figures = run_figures(data)
    worlds = {}
    for group, runs in partners(data, baseline).groupby("group", sort=False):
        both = [
            figures.loc[runs[name]].groupby(runs["seed"].to_numpy()).sum() for name in ("baseline_run_id", "run_id")
        ]
        worlds[str(group)] = (both[0].rename_axis("seed"), both[1].rename_axis("seed"))
    return worlds


def effect(data: Dataset, baseline: str = "none", confidence: float = 0.95) -> pd.DataFrame:
    """What every group with AEB changes against the baseline of the same seeds; the seed is the unit of the intervals.

    Args:
        data: runs with and without AEB, any number of groups.
        baseline: the strategy, or the name of the group of runs, that the others are compared with.
        confidence: of the intervals, 0 to 1.

    Returns:
        Index (group, figure, unit); columns `baseline`, `with_aeb`, `difference` with `low`, `high`; `percent` of the
        baseline with `percent_low`, `percent_high`; `seeds`, `method`, `percent_method`, `note`, as in
        `paired_interval`. Crashes are counted per run; expected deaths and seriously injured are lower bounds. Where no
        crash is left, the percentage's bound is that of two Poisson rates.

    Raises:
        InputError: as `partners`.
    """
    rows = []
    for group, (base, aeb) in figures_by_seed(data, baseline).items():
        for figure, unit, value, per in _FIGURES:
            change, percent = (
                paired_interval(
                    base[value], aeb[value], baseline_per=base[per], other_per=aeb[per], percent=relative,
                    confidence=confidence,
                )
                for relative in (False, True)
            )  # fmt: skip
            if value.endswith("crashes") and len(base) > 1 and base[value].any() and not aeb[value].any():
                percent = _none_left(base, value, aeb["runs"].sum(), percent, confidence)
            notes = dict.fromkeys(note for note in (change.note, percent.note) if note)
            rows.append(
                {"group": group, "figure": figure, "unit": unit, "baseline": _rate(base[value], base[per])}
                | {"with_aeb": _rate(aeb[value], aeb[per]), "difference": change.estimate}
                | {"low": change.low, "high": change.high, "percent": percent.estimate}
                | {"percent_low": percent.low, "percent_high": percent.high, "seeds": change.seeds}
                | {"method": change.method, "percent_method": percent.method, "note": "; ".join(notes)}
            )
    return pd.DataFrame(rows).set_index(["group", "figure", "unit"])


def _rate(value: pd.Series, per: pd.Series) -> float:
    return float(value.sum() / per.sum()) if per.sum() else np.nan


def _none_left(base: pd.DataFrame, value: str, runs: float, percent: Interval, confidence: float) -> Interval:
    """Seeds cannot tell how rare it is what none of them had."""
    ratio = rate_ratio(
        count=0, exposure=runs, baseline_count=int(base[value].sum()), baseline_exposure=base["runs"].sum(),
        confidence=confidence,
    )  # fmt: skip
    return replace(
        percent, low=-100.0, high=100 * (ratio.high - 1), method=POISSON,
        note="none left: crashes taken as independent",
    )  # fmt: skip
