"""When the systems acted, and how often."""

from collections.abc import Mapping

import pandas as pd

from analysis.interventions import equipped_km
from analysis.load import Dataset
from analysis.report.intervals import median, per_1000_km
from analysis.report.looks import ecdf, looks
from analysis.report.matching import is_baseline
from analysis.report.parts import Cell, Section, Table, count

__all__ = ["section"]

_PHASES = {"warn": "warning alone", "partial_brake": "partial braking", "full_brake": "full braking"}
_FAR = 10.0  # s, end of the axis of TTC: beyond it no AEB of the platform is meant to act


def section(everything: Mapping[str, Dataset]) -> Section | None:
    """Counts, rates and times to collision at the trigger; None without any run with an AEB."""
    groups = {name: part for name, part in everything.items() if not is_baseline(name)}
    if not groups:
        return None
    if not any(len(part.interventions) for part in groups.values()):
        return Section(
            id="interventions", title="Interventions", text=[("No system warned or braked in any of these runs.",)]
        )
    braking = {g: _braking(part) for g, part in groups.items()}
    figure = ecdf(
        "trigger-ttc", "Time to collision at the trigger",
        {g: some["trigger_ttc_s"].to_numpy(float) for g, some in braking.items()}, looks(everything),
        label="TTC at the first braking [s]", events="brakings", top=_FAR,
    )  # fmt: skip
    reduction = ecdf(
        "speed-reduction", "Speed taken off",
        {g: 3.6 * some["speed_reduction_mps"].to_numpy(float) for g, some in braking.items()}, looks(everything),
        label="speed reduction [km/h]", events="brakings",
    )  # fmt: skip
    table = Table(
        id="intervention-table", title="Interventions by highest phase",
        head=("group", "phase", "interventions", "rate", "median TTC at the first braking", "median speed reduction"),
        rows=[row for g, part in groups.items() for row in _rows(g, part)],
        note="Rate over the distance of the equipped vehicles, exact Poisson interval; medians with the interval "
        "between order statistics, of finite values alone: TTC is infinite where the gap is not closing.",
    )  # fmt: skip
    return Section(id="interventions", title="Interventions", figures=[figure, reduction], tables=[table])


def _braking(part: Dataset) -> pd.DataFrame:
    return part.interventions[part.interventions["phase"] != "warn"]


def _rows(group: str, part: Dataset) -> list[list[Cell]]:
    km = float(equipped_km(part).sum())
    rows: list[list[Cell]] = []
    for phase, name in _PHASES.items():
        some = part.interventions[part.interventions["phase"] == phase]
        key = f"{group}/{phase}"
        cells: list[Cell] = [group, name, count(f"{key}/count", len(some)), per_1000_km(f"{key}/rate", len(some), km)]
        if phase == "warn":
            cells += ["–", "–"]
        else:
            cells += [
                median(f"{key}/ttc", some["trigger_ttc_s"], "brakings", "s"),
                median(f"{key}/reduction", 3.6 * some["speed_reduction_mps"], "brakings", "km/h"),
            ]
        rows.append(cells)
    return rows
