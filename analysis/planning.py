"""How many seeds, or vehicle-km, are needed for a wanted precision, from what is there."""

from collections.abc import Callable

import numpy as np
import pandas as pd
from scipy.stats import chi2
from scipy.stats import t as student

from analysis.effect import figures_by_seed, run_figures
from analysis.load import Dataset
from analysis.statistics import LOG_RATIO, Interval, paired_interval

__all__ = [
    "dispersion",
    "events_needed",
    "exposure_without_events",
    "half_width_after",
    "planning",
    "relative_half_width",
    "seeds_needed",
]

_MOST = 1 << 40


def events_needed(relative: float, confidence: float = 0.95) -> int:
    """Events after which the exact Poisson interval's half-width is at most this share of the rate.

    Args:
        relative: wanted half-width by the rate, above 0; 0.2 takes 102 events.
        confidence: of the interval, 0 to 1.

    Raises:
        ValueError: a share that is not above 0, or a confidence outside 0..1.
    """
    if not relative > 0 or not 0 < confidence < 1:
        raise ValueError(f"relative {relative} must be above 0, confidence {confidence} within 0..1")
    return _smallest(lambda count: relative_half_width(count, confidence) <= relative, 1)


def relative_half_width(count: float, confidence: float = 0.95) -> float:
    """Half-width of the exact interval of a Poisson rate, by the rate.

    Args:
        count: events, above 0; those that are worth one each, if they come in clusters.
        confidence: of the interval, 0 to 1.
    """
    tail = (1 - confidence) / 2
    return float(chi2.ppf(1 - tail, 2 * count + 2) - chi2.ppf(tail, 2 * count)) / 4 / count


def exposure_without_events(rate: float, confidence: float = 0.95) -> float:
    """Exposure that has to pass without an event to show that the rate is below this: the rule of three, 3 / rate.

    Args:
        rate: to be ruled out, events per unit of exposure, above 0.
        confidence: of the (one-sided) statement, 0 to 1; at 0.95, -ln(0.05) = 2.996 is the three.
    """
    if not rate > 0 or not 0 < confidence < 1:
        raise ValueError(f"rate {rate} must be above 0, confidence {confidence} within 0..1")
    return float(-np.log1p(-confidence) / rate)


def seeds_needed(interval: Interval, half_width: float, confidence: float = 0.95) -> float:
    """Seeds, all in all, after which an interval of `paired_interval` has a half-width of at most this.

    As far as the spread between the seeds stays what it is so far, which a few seeds know poorly; that of a studentized
    bootstrap is taken as that of t. What is counted is the mean of the upper and the lower half.

    Args:
        interval: from the seeds that are there.
        half_width: wanted, in the unit of the interval (percentage points for percent), above 0.
        confidence: of the interval, as it was found.

    Returns:
        A whole number, at least 2; NaN where the interval has no bounds.

    Raises:
        ValueError: a half-width that is not above 0.
    """
    if not half_width > 0:
        raise ValueError(f"half_width {half_width} must be above 0")
    if not _bounded(interval):
        return float("nan")
    return float(_smallest(lambda seeds: half_width_after(interval, seeds, confidence) <= half_width, 2))


def half_width_after(interval: Interval, seeds: int, confidence: float = 0.95) -> float:
    """Half-width that an interval of `paired_interval` will have after so many seeds, as `seeds_needed` takes it.

    Args:
        interval: from the seeds that are there.
        seeds: all in all, 2 or more.
        confidence: of the interval, as it was found.

    Returns:
        In the unit of the interval; NaN where that has no bounds, or of one seed.
    """
    n, tail = interval.seeds, (1 + confidence) / 2
    if not _bounded(interval) or seeds < 2:
        return float("nan")
    logarithmic = interval.method == LOG_RATIO
    bounds = np.array([interval.low, interval.high])
    lower, upper = np.log1p(bounds / 100) if logarithmic else bounds
    spread = (upper - lower) / 2 / float(student.ppf(tail, n - 1)) * np.sqrt(n)
    one = float(student.ppf(tail, seeds - 1) * spread / np.sqrt(seeds))
    # At a ratio r the interval is r exp(-x) to r exp(x).
    return (100 + interval.estimate) * float(np.sinh(min(one, 700.0))) if logarithmic else one


def _bounded(interval: Interval) -> bool:
    return bool(np.isfinite([interval.low, interval.high]).all()) and interval.seeds > 1


def _smallest(enough: Callable[[int], bool], least: int) -> int:
    """Smallest whole number from `least` on that is enough, if all above it are."""
    low, high = least - 1, least
    while not enough(high) and high < _MOST:
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if enough(middle) else (middle, high)
    return high


def planning(
    data: Dataset, baseline: str = "none", *, relative: float = 0.2, points: float = 10.0, confidence: float = 0.95
) -> pd.DataFrame:
    """What is still needed until the intervals are as narrow as wanted.

    Args:
        data: runs with and without AEB.
        baseline: as in `effect`.
        relative: wanted half-width of the crash rate's interval, as a share of the rate; 0.2 is our assumption.
        points: wanted half-width of the interval of the reduction of crashes, in percentage points of the baseline; 10
            is our assumption.
        confidence: of the intervals, 0 to 1.

    Returns:
        Index (group, figure): `crash rate` of every group of runs, its half-width in percent of the rate; `reduction of
        crashes` and `reduction of primary crashes`, in points, of those with AEB. Columns: `half_width` now and
        `wanted`; `seeds` and `km` (vehicle-km) that are there, `seeds_needed` and `km_needed` in all, `seeds_missing`
        and `km_missing`, NaN where nothing can be said; `note`. Crashes come in clusters: a rate needs as many times
        more of them as their number varies more between the seeds than a Poisson number would. Without a crash the
        rate is below 3 by the distance (rule of three), so that at least so much is needed as that rate would take.

    Raises:
        InputError: as `partners`.
    """
    figures, seed = run_figures(data), data.runs.set_index("run_id")["seed"]
    rows: list[dict[str, float | str]] = []
    for group, part in data.by_group().items():
        own = figures.loc[part.runs["run_id"]]
        rows.append({"group": group, "figure": "crash rate", **_of_rate(own.groupby(seed).sum(), relative, confidence)})
    for group, (base, aeb) in figures_by_seed(data, baseline).items():
        for value in ("crashes", "primary_crashes"):
            change = paired_interval(
                base[value], aeb[value], baseline_per=base["runs"], other_per=aeb["runs"], percent=True,
                confidence=confidence,
            )  # fmt: skip
            figure, half_width = f"reduction of {value.replace('_', ' ')}", (change.high - change.low) / 2
            missing = _missing(aeb, seeds_needed(change, points, confidence), change.note)
            rows.append({"group": group, "figure": figure, "half_width": half_width, "wanted": points, **missing})
    columns = ["group", "figure", "half_width", "wanted", "seeds", "seeds_needed", "seeds_missing"]
    columns += ["km", "km_needed", "km_missing", "note"]
    return pd.DataFrame(rows, columns=columns).set_index(["group", "figure"])


def _of_rate(figures: pd.DataFrame, relative: float, confidence: float) -> dict[str, float | str]:
    """The row of a crash rate, from `run_figures` by seed."""
    km, crashes, seeds = figures["km"], figures["crashes"], len(figures)
    total, count = float(km.sum()), float(crashes.sum())
    row: dict[str, float | str] = {"half_width": np.nan, "wanted": 100 * relative}
    if not total:
        return row | _missing(figures, np.nan, "no distance")
    varies, note = dispersion(crashes, km), "one seed: crashes taken as independent"
    if not count:
        note = "no crash: at least so many"
    elif seeds > 1:
        note = f"the number varies {varies:.1f} times as much as a Poisson one" if varies > 1 else ""
    if count:
        row["half_width"] = 100 * relative_half_width(count / varies, confidence)
    # The largest rate that fits no crash in `total`: the rule of three read the other way round.
    rate = count / total if count else exposure_without_events(total, 0.95)
    needed = events_needed(relative, confidence) * varies / rate
    return row | _missing(figures, float(np.ceil(needed / (total / seeds))), note)


def dispersion(crashes: pd.Series, km: pd.Series) -> float:
    """How many times as much as a Poisson number the number of crashes varies between the seeds: they come in clusters.

    Args:
        crashes: by seed (n,).
        km: vehicle-km, in the same order (n,).

    Returns:
        1 or more; 1 where nothing is known, without crashes or with one seed.
    """
    count, seeds = float(crashes.sum()), len(crashes)
    if not count or seeds < 2:
        return 1.0
    residual = crashes - count / float(km.sum()) * km
    return max(1.0, float(np.sum(residual**2)) / (seeds - 1) / (count / seeds))


def _missing(figures: pd.DataFrame, needed: float, note: str) -> dict[str, float | str]:
    """Columns that say how much is there and how much is not."""
    seeds, km = len(figures), float(figures["km"].sum())
    missing = float(np.maximum(needed - seeds, 0.0))
    return {
        "seeds": seeds, "seeds_needed": needed, "seeds_missing": missing,
        "km": km, "km_needed": needed * km / seeds, "km_missing": missing * km / seeds, "note": note,
    }  # fmt: skip
