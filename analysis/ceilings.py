"""What is physics and what is the strategy: crashes that nobody could avoid by braking, and those that an AEB left."""

from collections.abc import Sequence
from typing import Any

import pandas as pd

from aeb_sumo.errors import InputError
from analysis.load import Dataset
from analysis.pairs import pairs
from analysis.shares import proportion

__all__ = ["ceiling_shares", "ceilings_left"]

_OUTCOMES = ("avoided", "mitigated", "unchanged", "worsened", "other", "unknown")
_KEY = ["run_id", "crash_id"]
_BEST, _CAREFUL = "perfect", "careful"


def ceiling_shares(data: Dataset, by: str | Sequence[str] = (), confidence: float = 0.95) -> pd.DataFrame:
    """How many crashes of the baseline each ceiling avoids.

    The interval takes crashes as independent. Those of one pile-up are not: where there are many, ask for
    `by="secondary"`.

    Args:
        data: runs with ceilings.
        by: columns of `crashes`, for example `kind`, `typology`, `striker_error` or `secondary`.
        confidence: of the intervals, 0 to 1.

    Returns:
        Index (ceiling, *by); columns `crashes`; of these `avoided`, `mitigated`, `unchanged`, `worsened`, `other`
        (avoided, but one of the equipped crashes with somebody else) and `unknown`; and of those that are known
        `percent` avoided, with Wilson's interval `low`, `high`.

    Raises:
        InputError: no run has ceilings, or `crashes` has no such column.
    """
    names = [by] if isinstance(by, str) else list(by)
    rows = []
    for key, some in _with_crashes(data, names).groupby(["ceiling", *names], sort=True):
        counts = {outcome: int((some["outcome"] == outcome).sum()) for outcome in _OUTCOMES}
        share = _percent(counts["avoided"], len(some) - counts["unknown"], confidence)
        rows.append(dict(zip(["ceiling", *names], key, strict=True)) | {"crashes": len(some)} | counts | share)
    return pd.DataFrame(rows).set_index(["ceiling", *names])


def ceilings_left(
    data: Dataset, by: str | Sequence[str] = (), baseline: str = "none", confidence: float = 0.95
) -> pd.DataFrame:
    """What an AEB fleet made of what physics allows: crashes of the baseline, matched with the run with AEB.

    Args:
        data: baselines with ceilings, and runs of the same seeds with AEB.
        by: columns of `crashes`, of the baseline.
        baseline: as in `analysis.pairs`.
        confidence: of the intervals, 0 to 1.

    Returns:
        Index (group, *by), group of the runs with AEB; columns `crashes` whose ceiling is known; `unavoidable` (perfect
        braking does not avoid them) and of these `avoided_anyway` (by an AEB, or as the traffic became another one);
        `avoidable`; of these `careful` (a careful driver avoids them), `avoided` under AEB and `left`; and `percent`
        left of the avoidable ones, with Wilson's interval `low`, `high`.

    Raises:
        InputError: no run has ceilings, `crashes` has no such column, or as `pairs`.
    """
    names = [by] if isinstance(by, str) else list(by)
    known = _with_crashes(data, names)
    known = known[known["outcome"] != "unknown"]
    ceiling = {name: known[known["ceiling"] == name] for name in (_BEST, _CAREFUL)}
    physics = ceiling[_BEST].assign(possible=ceiling[_BEST]["outcome"] == "avoided")
    careful = ceiling[_CAREFUL].assign(careful=ceiling[_CAREFUL]["outcome"] == "avoided")
    physics = physics.merge(careful[[*_KEY, "careful"]], on=_KEY, how="left")
    physics = physics.rename(columns=dict(zip(_KEY, ("baseline_run_id", "baseline_crash_id"), strict=True)))
    factual = pairs(data, baseline)
    factual = factual.assign(gone=factual["outcome"] == "avoided")[
        ["group", "baseline_run_id", "baseline_crash_id", "gone"]
    ]
    factual = factual.dropna(subset="baseline_crash_id").astype({"baseline_crash_id": "int64"})
    both = factual.merge(physics, on=["baseline_run_id", "baseline_crash_id"])
    rows = []
    for key, some in both.groupby(["group", *names], sort=True):
        possible, gone = some["possible"].astype(bool), some["gone"].astype(bool)
        counts = {
            "crashes": len(some),
            "unavoidable": int((~possible).sum()),
            "avoided_anyway": int((~possible & gone).sum()),
            "avoidable": int(possible.sum()),
            "careful": int((possible & some["careful"].eq(True)).sum()),
            "avoided": int((possible & gone).sum()),
            "left": int((possible & ~gone).sum()),
        }
        share = _percent(counts["left"], counts["avoidable"], confidence)
        rows.append(dict(zip(["group", *names], key, strict=True)) | counts | share)
    return pd.DataFrame(rows).set_index(["group", *names])


def _percent(count: int, total: int, confidence: float) -> dict[str, Any]:
    share = proportion(count, total, confidence)
    return {"percent": 100 * share.share, "low": 100 * share.low, "high": 100 * share.high}


def _with_crashes(data: Dataset, names: Sequence[str]) -> pd.DataFrame:
    """Table `ceilings` with some columns of the crashes."""
    if data.ceilings.empty:
        raise InputError("no run has ceilings; run the baseline with --ceilings, or aeb_sumo.ceilings.ceilings")
    for name in names:
        if name not in data.crashes.columns:
            raise InputError(f"crashes have no column {name!r}; there are: {', '.join(data.crashes.columns)}")
    return data.ceilings.merge(data.crashes[[*_KEY, *names]], on=_KEY)
