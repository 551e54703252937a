"""Quantities with their intervals, from what was counted."""

import numpy as np
import pandas as pd
from scipy.stats import binom
from statsmodels.stats.proportion import proportion_confint

from analysis.rates import poisson_rate
from analysis.report.parts import Quantity

__all__ = ["median", "per_1000_km", "share"]


def share(key: str, seen: int, n: int, of: str) -> Quantity:
    """A share in percent with Wilson's interval, which takes the events as independent."""
    if not n:
        return Quantity(key=key, value=np.nan, n=0, of=of, unit="%")
    low, high = proportion_confint(seen, n, method="wilson")
    return Quantity(key=key, value=100 * seen / n, low=100 * low, high=100 * high, n=n, of=of, unit="%")


def per_1000_km(key: str, seen: int, km: float) -> Quantity:
    """Events per 1,000 km with the exact Poisson interval, which takes the events as independent."""
    rate = poisson_rate(seen, km / 1000)
    high = rate.high if np.isfinite(rate.high) else np.nan
    return Quantity(key=key, value=rate.rate, low=rate.low, high=high, n=km, of="km", unit="per 1 000 km")


def median(key: str, values: pd.Series, of: str, unit: str) -> Quantity:
    """The median of the finite values with the interval between two order statistics (the sign test's).

    The interval covers at least 95 %; below six values there is none.
    """
    known = np.sort(values[np.isfinite(values)].to_numpy(float))
    n = known.size
    if not n:
        return Quantity(key=key, value=np.nan, of=of, unit=unit)
    below = int(binom.ppf(0.025, n, 0.5)) - 1  # values to cut off at each end
    while binom.cdf(below + 1, n, 0.5) <= 0.025:
        below += 1
    low, high = (known[below], known[n - 1 - below]) if below >= 0 else (np.nan, np.nan)
    note = "" if below >= 0 else "too few for an interval"
    return Quantity(key=key, value=float(np.median(known)), low=low, high=high, n=n, of=of, unit=unit, note=note)
