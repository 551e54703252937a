"""What became of the crashes of the baseline, counted, with intervals and tests."""

from dataclasses import replace

import numpy as np
import pandas as pd
from statsmodels.stats.contingency_tables import mcnemar

from analysis.load import Dataset
from analysis.pairs import OUTCOMES, pairs, partners
from analysis.rates import rate_ratio
from analysis.shares import share_by_seed
from analysis.statistics import POISSON, Interval, caution, paired_interval

__all__ = ["mcnemar_test", "pair_counts"]


def pair_counts(data: Dataset, baseline: str = "none", confidence: float = 0.95) -> pd.DataFrame:
    """Pairs by outcome, per group of runs with AEB.

    Args:
        data: runs with and without AEB.
        baseline: as in `pairs`.
        confidence: of the intervals, 0 to 1.

    Returns:
        Index (group, outcome), all outcomes in every group; columns `count`, of these `primary` (neither vehicle had
        crashed before, in the baseline, for `new` under AEB), `intervened` and `diverged` (of the avoided ones);
        `percent` of the baseline's crashes with its interval `low`, `high`, in which the seed is the cluster, as
        crashes of one pile-up are avoided together; `seeds`, `method`, `note`. New crashes can be above 100 %.

    Raises:
        InputError: as `partners`.
    """
    table, of_run = pairs(data, baseline), partners(data, baseline)
    rows = []
    for group, runs in of_run.groupby("group", sort=False):
        seeds = pd.Index(runs["seed"].unique())
        mine = table[table["group"] == group]
        crashes = _by_seed(mine[mine["outcome"] != "new"], seeds)
        for outcome in OUTCOMES:
            some = mine[mine["outcome"] == outcome]
            first = ~some["secondary" if outcome == "new" else "baseline_secondary"].astype(bool)
            interval = _share(_by_seed(some, seeds), crashes, confidence, part=outcome != "new")
            rows.append(
                {"group": group, "outcome": outcome, "count": len(some), "primary": int(first.sum())}
                | {how: int((some["how"] == how).sum()) for how in ("intervened", "diverged")}
                | {"percent": interval.estimate, "low": interval.low, "high": interval.high}
                | {"seeds": interval.seeds, "method": interval.method, "note": interval.note}
            )
    return pd.DataFrame(rows).set_index(["group", "outcome"])


def _by_seed(some: pd.DataFrame, seeds: pd.Index) -> pd.Series:
    return some.groupby("seed").size().reindex(seeds, fill_value=0).astype(float)


def _share(counts: pd.Series, crashes: pd.Series, confidence: float, *, part: bool) -> Interval:
    """In percent of the baseline's crashes; new ones are no part of them, so that there can be more."""
    total = int(crashes.sum())
    if part or not total:
        return share_by_seed(counts, crashes, confidence=confidence)
    found = paired_interval(0 * counts, 100 * counts, other_per=crashes, confidence=confidence)
    if len(counts) > 1 and not counts.any():
        most = rate_ratio(
            count=0, exposure=1.0, baseline_count=total, baseline_exposure=1.0, confidence=confidence
        )  # fmt: skip
        note = "none: crashes taken as independent"
        return replace(found, low=0.0, high=100 * most.high, method=POISSON, note=note)
    return replace(found, low=float(np.maximum(found.low, 0.0)), note=found.note or caution(crashes.to_numpy()))


def mcnemar_test(data: Dataset, baseline: str = "none") -> pd.DataFrame:
    """Exact McNemar test of pairs that crash in one of the two worlds only, per group of runs with AEB.

    It takes pairs as independent. Those of a pile-up are not, so the p-value of all crashes is too small: read the row
    of primary crashes, which leaves out those whose vehicles had crashed before.

    Args:
        data: runs with and without AEB.
        baseline: as in `pairs`.

    Returns:
        Index (group, crashes), crashes being `all` or `primary`; columns `only_baseline`, `only_aeb`, `both` and the
        two-sided `p_value`, 1 where no pair tells the worlds apart.

    Raises:
        InputError: as `partners`.
    """
    table = pairs(data, baseline)
    rows = []
    for group in partners(data, baseline)["group"].unique():
        mine = table[table["group"] == group]
        in_baseline, in_aeb = mine["outcome"] != "new", mine["outcome"] != "avoided"
        for name, of_baseline, of_aeb in (
            ("all", in_baseline, in_aeb),
            ("primary", in_baseline & mine["baseline_secondary"].eq(False), in_aeb & mine["secondary"].eq(False)),
        ):
            # A pair that crashes in both worlds does so, primary or not.
            only = int((of_baseline & ~in_aeb).sum()), int((of_aeb & ~in_baseline).sum())
            both = int(((of_baseline | of_aeb) & in_baseline & in_aeb).sum())
            p = float(mcnemar([[both, only[0]], [only[1], 0]], exact=True).pvalue) if sum(only) else 1.0
            rows.append(
                {"group": group, "crashes": name, "only_baseline": only[0], "only_aeb": only[1], "both": both}
                | {"p_value": min(p, 1.0)}
            )
    return pd.DataFrame(rows).set_index(["group", "crashes"])
