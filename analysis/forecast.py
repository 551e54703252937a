"""What runs that are planned will show, from runs that are there."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from analysis.planning import dispersion, half_width_after, relative_half_width
from analysis.rates import poisson_rate
from analysis.statistics import paired_interval

__all__ = ["Forecast", "difference_half_width", "forecast"]


@dataclass(frozen=True, kw_only=True)
class Forecast:
    """Crashes to come.

    Attributes:
        crashes: to expect.
        low, high: bounds of what to expect (95 %), as far as the rate is known so far; the scatter of what comes is not
            in it.
        rate: crashes per vehicle-km so far.
        half_width: that the 95 % interval of the rate will have [1/km].
        dispersion: how many times as much as a Poisson number the number of crashes varies; as in `dispersion`.
    """

    crashes: float
    low: float
    high: float
    rate: float
    half_width: float
    dispersion: float


def forecast(figures: pd.DataFrame, *, km: float) -> Forecast:
    """What a group of runs will show.

    Args:
        figures: columns `crashes` and `km` (vehicle-km), a row per seed (n,).
        km: vehicle-km planned, above 0.

    Returns:
        NaN throughout without any distance so far. A rate at which nothing has happened so far has the half-width that
        it would have if nothing happened.
    """
    seen, count = float(figures["km"].sum()), float(figures["crashes"].sum())
    if not seen:
        return Forecast(crashes=np.nan, low=np.nan, high=np.nan, rate=np.nan, half_width=np.nan, dispersion=1.0)
    varies = dispersion(figures["crashes"], figures["km"])
    rate = count / seen
    # Crashes that come in clusters of so many tell no more than so many fewer that do not.
    bounds = poisson_rate(round(count / varies), seen / varies)
    width = rate * relative_half_width(rate * km / varies) if count else poisson_rate(0, km).high / 2
    low, high = min(bounds.low, rate), max(bounds.high, rate)
    return Forecast(
        crashes=rate * km, low=low * km, high=high * km, rate=rate, half_width=width, dispersion=varies
    )  # fmt: skip


def difference_half_width(
    baseline: pd.DataFrame, other: pd.DataFrame, *, seeds: int, baseline_km: float, km: float
) -> tuple[float, bool]:
    """Half-width that the 95 % interval of a difference of crash rates will have.

    Args:
        baseline: as `figures` of `forecast`, index `seed`.
        other: the same of the runs that are compared with it.
        seeds: planned of each.
        baseline_km: vehicle-km planned of the baseline, above 0.
        km: of the other, above 0.

    Returns:
        The half-width [1/km], and whether it is from pairs of seeds; with fewer than three of them, the rates are taken
        as independent, which is wider if the seeds are alike.
    """
    common = baseline.index.intersection(other.index)
    if len(common) > 2 and seeds > 1:
        base, aeb = baseline.loc[common], other.loc[common]
        interval = paired_interval(base["crashes"], aeb["crashes"], baseline_per=base["km"], other_per=aeb["km"])
        width = half_width_after(interval, seeds)
        if np.isfinite(width):
            return width, True
    return float(np.hypot(forecast(baseline, km=baseline_km).half_width, forecast(other, km=km).half_width)), False
