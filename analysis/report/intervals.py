"""Quantities with their intervals, from what was counted."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import binom

from analysis.rates import poisson_rate
from analysis.report.parts import Quantity
from analysis.shares import proportion, share_by_seed

__all__ = ["median", "of_row", "per_1000_km", "records", "share"]


def share(key: str, seen: pd.Series, seed: pd.Series, of: str) -> Quantity:
    """A share in percent; events of one seed may depend on each other, so the seed is the cluster.

    Of one seed alone, Wilson's interval, which takes events as independent, and a note that says so.

    Args:
        key: of the quantity.
        seen: per event, whether it is of the kind.
        seed: per event.
        of: what the events are.
    """
    n, k = len(seen), seed.nunique()
    if not n:
        return Quantity(key=key, value=np.nan, of=of, unit="%")
    if k > 1:
        found = share_by_seed(seen.groupby(seed).sum(), seen.groupby(seed).size())
        low, high, note = found.low, found.high, f"{k} seeds"
    else:
        one = proportion(int(seen.sum()), n)
        low, high, note = 100 * one.low, 100 * one.high, "one seed, taken as independent"
    return Quantity(key=key, value=100 * seen.mean(), low=low, high=high, n=n, of=of, unit="%", note=note)


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


def of_row(
    key: str, row: Mapping[str, Any], value: str = "difference", *, unit: str = "", avoided: bool = False
) -> Quantity:
    """A change over seeds, from a row of `effect`, `pair_counts` or `traffic_price`.

    Args:
        key: of the quantity.
        row: with `value`, its bounds, `seeds` and `note`.
        value: the column; its bounds are `low` and `high`, or those with its name before them, where there are any.
        unit: of it.
        avoided: turn a change into a decrease.
    """
    before = f"{value}_" if f"{value}_low" in row else ""
    middle, low, high = float(row[value]), float(row[f"{before}low"]), float(row[f"{before}high"])
    if avoided:
        middle, low, high = -middle, -high, -low
    # That seeds are few is said once, at the head of the page.
    note = "; ".join(part for part in str(row["note"]).split("; ") if part and not part.startswith("few seeds"))
    note = f"no interval: {note}" if note and np.isnan(low) else note
    return Quantity(
        key=key, value=middle, low=low, high=high, n=int(row["seeds"]), of="seeds", unit=unit, note=note,
        signed=value == "difference" and not avoided,
    )  # fmt: skip


def records(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """Rows of a frame, its index among the columns."""
    return [{str(name): value for name, value in row.items()} for row in frame.reset_index().to_dict("records")]
