"""What the traffic pays for an AEB fleet, or gains by it: against the baseline of the same seeds, with intervals."""

from collections.abc import Callable

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import t as student

from aeb_sumo.errors import InputError
from analysis.load import Dataset
from analysis.pairs import partners
from analysis.statistics import Interval, paired_interval

__all__ = ["delay_per_avoided_crash", "traffic_price"]

_WINDOW = 300.0  # s, over which the largest flow is looked for, our assumption

_Floats = NDArray[np.float64]


# (figure, unit) -> of the table with one row per run: the figure, and what it is counted over, if it is a rate.
_FIGURES: dict[tuple[str, str], Callable[[pd.DataFrame], tuple[pd.Series, pd.Series | None]]] = {
    ("flow", "1/h"): lambda r: (r["arrived"], r["hours"]),
    ("largest flow in 5 min", "1/h"): lambda r: (r["largest_flow"], None),
    ("flow per lane out of queues", "1/h"): lambda r: (r["discharged"], r["headway_s"] / 3600),
    ("travel time", "s"): lambda r: (r["travel_time_s"], r["arrived"]),
    ("speed", "km/h"): lambda r: (r["distance_m"] * 3.6, r["time_s"]),
    ("delay on the road", "s/km"): lambda r: (r["delay_s"], r["distance_m"] / 1000),
    ("stops", "1/km"): lambda r: (r["stops"], r["distance_m"] / 1000),
    ("standing", "h"): lambda r: (r["standing_s"] / 3600, None),
    ("delay", "h"): lambda r: (r["lost_h"], None),
    ("  waiting to enter", "h"): lambda r: (r["waiting_s"] / 3600, None),
    ("  behind wrecks", "h"): lambda r: (r["blocked_s"] / 3600, None),
    ("crashes", ""): lambda r: (r["crashes"], None),
}
_PER_CRASH = ("extra delay per avoided crash", "h")


def traffic_price(
    data: Dataset, baseline: str = "none", *, warm_up: float = 0.0, confidence: float = 0.95
) -> pd.DataFrame:
    """What the traffic got through with AEB, against the baseline run of the same seed.

    Figures without a rate are means per run, those with one sums by sums. `delay` is the time lost on the road against
    driving at the allowed speed, wrecks included, and that lost by waiting for a place to enter; `behind wrecks` is a
    part of it, and its difference what avoided blockages saved (negative): `aeb_sumo.ledger.queues` says what it
    counts. `flow per lane out of queues` is the capacity at bottlenecks (`aeb_sumo.ledger.bottlenecks`); `largest flow
    in 5 min` (our assumption) is the most that arrived, a capacity only where the demand exceeds it. `travel time` is
    that of vehicles that arrived: those still on the road do not count.

    Args:
        data: runs with and without AEB.
        baseline: the strategy, or the name of the group of runs, that the others are compared with.
        warm_up: intervals and crashes that begin earlier than this after the begin of a run do not count [s]; by
            default all counts, also that the network is empty at first, in both worlds alike.
        confidence: of the intervals, 0 to 1.

    Returns:
        Index (group, figure, unit), one row per figure and AEB group; columns `baseline`, `with_aeb`, `difference`,
        `percent` of the baseline; `low`, `high` of the difference, by `analysis.paired_interval`; `seeds` that they
        rest on; and `note`. The last row of a group is what `delay_per_avoided_crash` says, as a `difference`.

    Raises:
        InputError: as `analysis.pairs.partners`, or nothing is left after the warm-up.
    """
    per_run = _per_run(data, warm_up)
    rows = []
    for group, runs in partners(data, baseline).groupby("group", sort=False):
        before, after = per_run.loc[runs["baseline_run_id"]], per_run.loc[runs["run_id"]]
        for (figure, unit), of in _FIGURES.items():
            (b, wb), (a, wa) = ((_array(x), _array(w, len(runs))) for x, w in (of(before), of(after)))
            there = ~np.isnan(np.stack([b, a])).any(0)
            old, new = (_by(x[there].sum(), w[there].sum()) for x, w in ((b, wb), (a, wa)))
            found = paired_interval(b, a, baseline_per=wb, other_per=wa, confidence=confidence)
            row = {"group": group, "figure": figure, "unit": unit, "baseline": old, "with_aeb": new}
            rows.append(row | {"percent": 100 * _by(new - old, old)} | _columns(found))
        avoided = _array(before["crashes"]) - _array(after["crashes"])
        found = delay_per_avoided_crash(
            _array(after["lost_h"]) - _array(before["lost_h"]), avoided, confidence=confidence
        )
        rows.append({"group": group, "figure": _PER_CRASH[0], "unit": _PER_CRASH[1]} | _columns(found))
    columns = ["baseline", "with_aeb", "difference", "percent", "low", "high", "seeds", "note"]
    return pd.DataFrame(rows).set_index(["group", "figure", "unit"])[columns]


def delay_per_avoided_crash(extra: _Floats, avoided: _Floats, *, confidence: float = 0.95) -> Interval:
    """Extra delay by avoided crashes, with the interval of Fieller (1954) for a ratio of two means over seeds.

    Args:
        extra: (n,) delay with AEB less that of the baseline, by seed [h]; negative where the AEB saves time.
        avoided: (n,) crashes of the baseline less those with AEB, by seed.
        confidence: of the interval, 0 to 1.

    Returns:
        Hours of delay per crash, negative where both are saved. Undefined (NaN) when no crash is avoided on the whole;
        without bounds (-inf to inf) when the number of avoided crashes cannot be told from zero; bounds are NaN with
        one seed, and where all seeds agree exactly.
    """
    n = len(extra)
    x, y = float(extra.mean()) if n else np.nan, float(avoided.mean()) if n else np.nan
    if not y > 0:
        return _interval(np.nan, np.nan, np.nan, n, "no crash avoided")
    if n == 1:
        return _interval(x / y, np.nan, np.nan, n, "one seed has no spread")
    (xx, xy), (_, yy) = np.cov(extra, avoided) * student.ppf((1 + confidence) / 2, n - 1) ** 2 / n
    # r is inside if (x - r y)^2 <= xx - 2 r xy + r^2 yy, in units of t^2 times the variances of the means.
    a, b, c = y**2 - yy, x * y - xy, x**2 - xx
    if a <= 0:
        return _interval(x / y, -np.inf, np.inf, n, "too few avoided crashes to tell")
    half = np.sqrt(max(b**2 - a * c, 0.0))
    if half <= 1e-12 * max(abs(b), 1e-300):
        return _interval(x / y, np.nan, np.nan, n, "the seeds do not differ")
    return _interval(x / y, (b - half) / a, (b + half) / a, n, "")


def _interval(estimate: float, low: float, high: float, seeds: int, note: str) -> Interval:
    return Interval(estimate=estimate, low=float(low), high=float(high), seeds=seeds, method="Fieller", note=note)


def _per_run(data: Dataset, warm_up: float) -> pd.DataFrame:
    """Sums over the time after the warm-up, one row per run."""
    runs = data.runs.set_index("run_id")
    start = runs["begin_s"] + warm_up
    if not (warm_up >= 0 and (start < runs["end_s"]).all()):
        raise InputError(f"warm-up of {warm_up:g} s: must be 0 or more, and less than any run lasts")
    traffic = data.traffic[data.traffic["begin_s"] > data.traffic["run_id"].map(start).astype(float) - 1e-6]
    sums = traffic.drop(columns=["begin_s", "end_s", "vclass"]).groupby("run_id").sum().reindex(runs.index).fillna(0.0)
    late = data.crashes["time_s"] >= data.crashes["run_id"].map(start).astype(float)
    sums["crashes"] = data.crashes[late].groupby("run_id").size().reindex(runs.index).fillna(0)
    sums["lost_h"] = (sums["delay_s"] + sums["waiting_s"]) / 3600
    sums["hours"] = (runs["end_s"] - start) / 3600
    largest = {name: _largest_flow(rows) for name, rows in traffic.groupby("run_id")}
    sums["largest_flow"] = pd.Series(largest, dtype=float)
    return sums


def _largest_flow(traffic: pd.DataFrame) -> float:
    """Largest flow of arrivals over 5 min, or the next longer span of whole intervals [1/h]; NaN if it is shorter."""
    arrived = traffic.groupby(["begin_s", "end_s"])["arrived"].sum().sort_index()
    begin, end = (arrived.index.get_level_values(k).to_numpy(float) for k in (0, 1))
    until = np.concatenate([[0.0], arrived.cumsum().to_numpy(float)])
    first = np.searchsorted(begin, end - _WINDOW + 1e-6, side="right") - 1
    full = first >= 0
    if not full.any():
        return np.nan
    span = end[full] - begin[first[full]]
    return float(((until[1:][full] - until[first[full]]) / span).max() * 3600)


def _array(values: pd.Series | None, n: int = 0) -> _Floats:
    return np.ones(n) if values is None else values.to_numpy(float)


def _by(value: float, per: float) -> float:
    return float(value / per) if per else np.nan


def _columns(found: Interval) -> dict[str, float | int | str]:
    return {
        "difference": found.estimate, "low": found.low, "high": found.high, "seeds": found.seeds, "note": found.note,
    }  # fmt: skip
