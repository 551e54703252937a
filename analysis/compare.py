"""Everything at a glance, side by side."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from aeb_sumo.results import VERDICTS
from analysis.conflicts import near_crash_ratio
from analysis.crashes import crash_rates
from analysis.interventions import equipped_km
from analysis.load import Dataset
from analysis.throughput import throughput

__all__ = ["compare", "summary"]

_OF_INTERVENTIONS = [
    *("phase", "target_kind", "strategy", "verdict"),
    *("trigger_ttc_s", "max_decel_mps2", "speed_reduction_mps"),
]
_OF_CONFLICTS = ["kind", "near_crash", "pet_s", "exposed_s"]
_SECTIONS = ("runs", "crashes", "conflicts", "interventions", "verdicts", "traffic", "checks")


def _figures(part: Dataset) -> dict[tuple[str, str, str], Any]:
    """All figures of one group of runs: (section, figure, unit) -> value."""
    (rate,) = crash_rates(part).itertuples()
    (ratio,) = near_crash_ratio(part).itertuples()
    crashes, runs = part.crashes, part.runs
    interventions, conflicts = part.read("interventions", _OF_INTERVENTIONS), part.read("conflicts", _OF_CONFLICTS)
    braking = interventions[interventions["phase"] != "warn"]
    km = equipped_km(part)
    figures: dict[tuple[str, str, str], Any] = {("runs", "runs", ""): len(runs)}
    figures["runs", "vehicles", ""] = runs["vehicles"].sum()
    figures["runs", "vehicle-km", "km"] = rate.vehicle_km
    figures["crashes", "crashes", ""] = rate.crashes
    for kind, count in crashes["kind"].value_counts().sort_index().items():
        figures["crashes", f"  {str(kind).replace('_', ' ')}", ""] = count
    figures["crashes", "  secondary", ""] = crashes["secondary"].sum()
    figures["crashes", "crash rate", "1/10⁶ km"] = rate.per_million_km
    figures["crashes", "  95 % from", "1/10⁶ km"] = rate.low
    figures["crashes", "  95 % to", "1/10⁶ km"] = rate.high
    figures["crashes", "mean impact speed", "km/h"] = crashes["impact_speed_mps"].mean() * 3.6
    figures["crashes", "expected deaths", "persons"] = _expected(crashes, "death")
    figures["crashes", "expected seriously injured", "persons"] = _expected(crashes, "serious")
    figures["conflicts", "conflicts", ""] = len(conflicts)
    for kind in ("following", "crossing"):
        figures["conflicts", f"  {kind}", ""] = (conflicts["kind"] == kind).sum()
    figures["conflicts", "near-crashes", ""] = conflicts["near_crash"].sum()
    figures["conflicts", "primary rear-end near-crashes per crash", "1"] = ratio.ratio
    figures["conflicts", "  95 % from", "1"] = ratio.low
    figures["conflicts", "  95 % to", "1"] = ratio.high
    figures["conflicts", "median PET", "s"] = conflicts["pet_s"].median()
    figures["conflicts", "time at a TTC below 1.5 s", "s"] = conflicts["exposed_s"].sum()
    figures["interventions", "interventions", ""] = len(interventions)
    for phase in ("warn", "partial_brake", "full_brake"):
        figures["interventions", f"  {phase.replace('_', ' ')}", ""] = (interventions["phase"] == phase).sum()
    for kind in ("lead", "crossing"):
        figures["interventions", f"  braking for {kind}", ""] = (braking["target_kind"] == kind).sum()
    figures["interventions", "braking rate", "1/10³ km"] = _per_1000_km(len(braking), km.sum())
    if len(km) > 1:
        for system, own in km.items():
            count = (braking["strategy"] == system).sum()
            figures["interventions", f"  {system}", "1/10³ km"] = _per_1000_km(count, own)
    ttc = braking["trigger_ttc_s"].replace(np.inf, np.nan)
    figures["interventions", "median TTC at braking", "s"] = ttc.median()
    figures["interventions", "mean peak deceleration", "m/s²"] = braking["max_decel_mps2"].mean()
    figures["interventions", "mean speed reduction", "km/h"] = braking["speed_reduction_mps"].mean() * 3.6
    verdicts = interventions.loc[interventions["verdict"].isin(VERDICTS), "verdict"].value_counts()
    figures["verdicts", "interventions with a verdict", ""] = verdicts.sum()
    figures |= {("verdicts", f"  {verdict}", ""): verdicts[verdict] for verdict in VERDICTS if verdict in verdicts}
    figures |= {("traffic", *figure): value for figure, value in _traffic(part).items()}
    figures["checks", "SUMO's own collisions", ""] = runs["sumo_collisions"].sum()
    figures["checks", "  also counted here", ""] = runs["confirmed_by_sumo"].sum()
    figures["checks", "contacts dismissed", ""] = runs["contacts_dismissed"].sum()
    figures["checks", "override violations", ""] = runs["override_violations"].sum()
    return figures


def _expected(crashes: pd.DataFrame, what: str) -> float:
    """Sum of the risks of all persons for whom there is a curve."""
    return float(crashes[[f"striker_{what}_risk", f"struck_{what}_risk"]].sum().sum())


def _traffic(part: Dataset) -> dict[tuple[str, str], Any]:
    (flow,) = throughput(part).itertuples()
    traffic = part.traffic
    return {
        ("arrivals", ""): flow.arrived,
        ("still waiting to enter", ""): flow.pending,
        ("flow", "1/h"): flow.flow_vph,
        ("flow per lane out of queues", "1/h"): _mean(traffic["discharged"], traffic["headway_s"] / 3600),
        ("mean speed", "km/h"): flow.speed_kmh,
        ("mean travel time", "s"): _mean(traffic["travel_time_s"], traffic["arrived"]),
        ("delay", "s/km"): flow.delay_s_per_km,
        ("delay behind wrecks", "h"): traffic["blocked_s"].sum() / 3600,
        ("stops", "1/km"): _mean(traffic["stops"], traffic["distance_m"] / 1000),
    }


def _mean(values: pd.Series, per: pd.Series) -> float:
    """Sum by sum."""
    return float(values.sum() / per.sum()) if per.sum() else np.nan


def _per_1000_km(count: int, km: float) -> float:
    return count / km * 1000 if km else np.nan


def _side_by_side(groups: Mapping[str, Dataset]) -> pd.DataFrame:
    columns = {name: pd.Series(_figures(part), dtype=float) for name, part in groups.items()}
    # Not every group has every kind of crash: keep the order of sections and figures as they come.
    order = dict.fromkeys(key for section in _SECTIONS for column in columns.values() for key in column.index
                          if key[0] == section and not key[1].startswith("  "))  # fmt: skip
    rows = []
    for key in order:
        rows.append(key)
        for column in columns.values():
            index = list(column.index)
            at = index.index(key) + 1
            while at < len(index) and index[at][1].startswith("  "):
                if index[at] not in rows:
                    rows.append(index[at])
                at += 1
    frame = pd.DataFrame(columns).reindex(pd.MultiIndex.from_tuples(rows, names=["section", "figure", "unit"]))
    counts = frame.index.get_level_values("unit") == ""
    frame[counts] = frame[counts].fillna(0)
    if len(groups) == 2:
        first, second = groups
        frame["difference"] = frame[second] - frame[first]
        # The ends of two intervals have no difference that means anything.
        frame.loc[frame.index.get_level_values("figure").str.startswith("  95 %"), "difference"] = np.nan
    return frame


def summary(data: Dataset) -> pd.DataFrame:
    """All figures, one column per group of runs and, for two groups, their difference.

    Returns:
        Index (section, figure, unit), values float; NaN where a figure does not exist.
    """
    return _side_by_side(data.by_group())


def compare(**data: Dataset) -> pd.DataFrame:
    """All figures of several data sets side by side; every group of each is a column, named `name: group`."""
    groups = {f"{name}: {group}": part for name, dataset in data.items() for group, part in dataset.by_group().items()}
    return _side_by_side(groups)
