"""The interventions that have a verdict, by group of runs."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import pandas as pd

from analysis.interventions import equipped_km
from analysis.load import Dataset
from analysis.report.intervals import records, share
from analysis.report.matching import is_baseline
from analysis.report.parts import Quantity
from analysis.verdicts import passed_on, precision_recall, verdict_rates

__all__ = ["Judged", "judged"]


@dataclass(frozen=True, kw_only=True)
class Judged:
    """The interventions of a group that have a verdict.

    Attributes:
        all: their rows, also those whose verdict is unknown.
        known: rows with a known verdict, and column `seed`.
        without: interventions that have no verdict.
        km: distance of the equipped vehicles; NaN where only a sample is judged [km].
        rates: rows of `analysis.verdict_rates`, by verdict.
        quality: row of `analysis.precision_recall`; None where nothing is judged.
        passed_on: rows of `analysis.passed_on`.
    """

    all: pd.DataFrame
    known: pd.DataFrame
    without: int
    km: float
    rates: dict[str, dict[str, Any]]
    quality: dict[str, Any] | None
    passed_on: list[dict[str, Any]]

    def count(self, verdict: str) -> int:
        """Interventions with this verdict."""
        return int((self.all["verdict"] == verdict).sum())

    def share(self, key: str, verdict: str) -> Quantity:
        """Their share of those with a known one."""
        return share(key, self.known["verdict"] == verdict, self.known["seed"], "verdicts")


def judged(data: Dataset, groups: Mapping[str, Dataset]) -> dict[str, Judged]:
    """Of every group with an AEB.

    Args:
        data: all runs.
        groups: `data.by_group()`.
    """
    result = {}
    rates, quality, hard = (records(f(data)) for f in (verdict_rates, precision_recall, passed_on))
    for name, part in groups.items():
        if not is_baseline(name):
            told = part.interventions["verdict"].fillna("")
            rows = part.interventions[told != ""]
            known = rows[rows["verdict"] != "unknown"]
            known = known.assign(seed=known["run_id"].map(part.runs.set_index("run_id")["seed"]))
            without = int((told == "").sum())
            result[name] = Judged(
                all=rows,
                known=known,
                without=without,
                km=float("nan") if without else float(equipped_km(part).sum()),
                rates={r["verdict"]: r for r in rates if r["group"] == name},
                quality=next((r for r in quality if r["group"] == name), None),
                passed_on=[r for r in hard if r["group"] == name],
            )
    return result
