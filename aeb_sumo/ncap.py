"""A strategy on the proving ground: a grid of test cases over test speeds, scored as protocols do.

The grid is ours, put together from what the sources print; it is nobody's official one. The scores are those of
`aeb_sumo.scores`.
"""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from aeb_sumo.drive import Case, Drive, body_distance, drive_all
from aeb_sumo.errors import InputError
from aeb_sumo.perception.suites import suite
from aeb_sumo.scenarios import Scenario
from aeb_sumo.scenarios.cases import approach, left_turn
from aeb_sumo.scores import (
    Colour,
    ccrm_windows,
    cncap_score,
    euroncap_colour,
    euroncap_score,
    r152_max_impact_speed_kmh,
    r152_passes,
)
from aeb_sumo.strategies.base import Strategy
from aeb_sumo.units import KMH

__all__ = ["GRID", "LEGEND", "MU", "Cell", "Outcome", "assess", "label", "outcome", "points", "run_grid"]

MU = 0.85
"""Friction coefficient of a dry road, from another source (Zhao et al. 2025, 3.1)."""

_STEP = 0.02  # s, our assumption
_AHEAD = 6.0  # s to collision at the start, our assumption: longer than any warning
_CLOSING_IN = ("ccrs", "ccrm")  # cases at one relative speed
_LEAD_KMH = 20  # CCRm; printed (Zhao et al. 2025, Table 6)
_HEADWAY = 1.0  # s, CCRb; from another source (Euro NCAP 2026); between the bumpers, our reading
_LEAD_DECEL = 4.0  # m/s2, CCRb; from another source (Euro NCAP 2026)
_LEAD_BRAKES_AT = 2.0  # s, our assumption: the sensors have confirmed the lead by then
_SETTLED = 6.0  # s after the contact of a car that does not brake, our assumption: time for one that does to stop
_CCRB_DURATION = 10.0  # s, our assumption: the lead stands after 5.5
_CNCAP_AEB_KMH = {"ccrs": (20, 40), "ccrm": (30, 50)}  # from another source (evidence.md); at others it tests warnings


@dataclass(frozen=True, order=True)
class Cell:
    """One test.

    Attributes:
        case: ccrs, ccrm, ccrb or left_turn.
        overlap: share of the lead's width that lies in the ego's.
        test_speed_kmh: of the car under test.
    """

    case: str
    overlap: float
    test_speed_kmh: int

    @property
    def target_speed_kmh(self) -> int:
        """Of the target at the start, along its own path."""
        return {"ccrs": 0, "ccrm": _LEAD_KMH, "ccrb": self.test_speed_kmh, "left_turn": 20}[self.case]

    @property
    def relative_speed_kmh(self) -> float:
        """At which the two would meet if nobody braked; nan where protocols have no such speed (CCRb, turns)."""
        return float(self.test_speed_kmh - self.target_speed_kmh) if self.case in _CLOSING_IN else float("nan")

    @property
    def avoidance_only(self) -> bool:
        """Euro NCAP gives nothing for a slower impact in turns."""
        return self.case == "left_turn"

    def scenario(self, mu: float = MU) -> Scenario:
        """The test in SUMO, on a road of friction coefficient `mu`."""
        ego, name = self.test_speed_kmh * KMH, f"{label(self.case, self.overlap)} {self.test_speed_kmh} km/h"
        if self.case == "left_turn":
            return left_turn(name, ego_kmh=self.test_speed_kmh, mu=mu, step_length=_STEP)
        common: dict[str, Any] = {"ego": ego, "mu": mu, "overlap": self.overlap, "step_length": _STEP}
        if self.case == "ccrb":
            braking = (_LEAD_BRAKES_AT, _LEAD_DECEL)
            return approach(name, lead=ego, gap=_HEADWAY * ego, braking=braking, duration=_CCRB_DURATION, **common)
        closing = self.relative_speed_kmh * KMH
        lead = self.target_speed_kmh * KMH
        return approach(name, lead=lead, gap=_AHEAD * closing, duration=_AHEAD + _SETTLED, **common)


GRID: tuple[Cell, ...] = tuple(
    Cell(case, overlap, speed)
    for case, overlap, speeds in (
        # 100 %: 20 to 40 and 30 to 50 km/h printed (Zhao et al. 2025, Table 6), up to 80 from another source
        # (evidence.md), 10 km/h our assumption. 50 %: printed (the comparison of cars M and N) for CCRm at 40 km/h,
        # at other speeds and for CCRs our assumption.
        ("ccrs", 1.0, range(10, 90, 10)),
        ("ccrs", 0.5, range(10, 90, 10)),
        ("ccrm", 1.0, range(30, 90, 10)),
        ("ccrm", 0.5, range(30, 90, 10)),
        ("ccrb", 1.0, (50,)),  # from another source (evidence.md)
        ("left_turn", 1.0, (10, 20, 30)),  # printed (Yan et al. 2025, Table 3)
    )
    for speed in speeds
)
"""All tests, line by line: cells of one case and overlap make a line."""

LEGEND = (
    "Letter: Euro NCAP 2026's colour (Green Yellow Orange Brown Red) by the impact speed beside it, which is the "
    "relative speed at contact [km/h]; no number: no contact. Its bands go by the speed of the tested car, in CCRm "
    "too, where a car that does not brake at all therefore still gets brown up to 50 km/h.",
    "CCRs: the target stands; CCRm: it drives 20 km/h; CCRb: 50 km/h, 1 s ahead, brakes with 4 m/s2; left turn: across "
    "an oncoming e-bike of 20 km/h on the path of Yan et al. 2025, like CBTA, only avoiding counts. Behind the name: "
    "overlap, which makes no difference to ideal sensing. Robots drive, and only the AEB brakes; one run per test.",
    "Euro NCAP %: mean score of the cells (1, 3/4, 1/2, 1/4, 0), every cell alike. It is not the official result, "
    "which weighs standard range, extended range and robustness 80:10:10 over its own grid.",
    "C-NCAP %: share of the relative speed taken away, mean over the speeds at which C-NCAP tests the AEB (CCRs 20 to "
    "40, CCRm 30 to 50 km/h).",
    "UN R152: tests passed of those it has a limit for: CCRs and CCRm, 100 % overlap, relative speed up to 60 km/h.",
    "Windows: CCRm tests with a warning at TTC 2 to 4 s, a smallest gap of 0.6 to 2.0 m and up to 10 m/s2, all three.",
)
"""What the figures mean, a paragraph each."""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What came of a test.

    Attributes:
        impact_speed_kmh: relative speed at contact, nan for none.
        warning_ttc: gap by closing speed when the warning began [s]; nan without one, and in turns.
        min_gap: smallest distance of the bodies, 0 after a contact [m].
        peak_decel: of the tested car up to a contact, no filter [m/s2].
    """

    impact_speed_kmh: float
    warning_ttc: float
    min_gap: float
    peak_decel: float


def run_grid(
    strategy: Strategy,
    *,
    cells: Sequence[Cell] = GRID,
    sensing: str | None = None,
    mu: float = MU,
    workers: int | None = None,
    done: Callable[[], None] | None = None,
) -> pd.DataFrame:
    """Run the tests in SUMO and score them.

    Args:
        strategy: the AEB under test.
        cells: the tests.
        sensing: name of a sensor suite; None for the strategy's own.
        mu: friction coefficient of the road, 0.05 to 1.5.
        workers: processes; None for one per processor.
        done: called after every test.

    Returns:
        One row per cell: `strategy`, `sensing`, `mu`, and the columns of `assess`; `error` says why SUMO failed, "" if
        it did not.

    Raises:
        InputError: there is no such suite, or `mu` or `workers` are out of range.
    """
    eyes = suite(sensing or strategy.sensing).name
    if not 0.05 <= mu <= 1.5:
        raise InputError(f"mu must be within 0.05 .. 1.5, not {mu:g}")
    if workers is not None and workers < 1:
        raise InputError(f"workers must be 1 or more, not {workers}")
    cases = {
        # In CCRb the gap may stop shrinking and shrink again; the e-bike never is ahead.
        cell: Case(scenario=cell.scenario(mu), strategy=strategy, sensing=eyes, until_over=cell.case in _CLOSING_IN)
        for cell in cells
    }
    errors: dict[Cell, str] = {}
    drives = drive_all(cases, workers=workers, done=done, failed=lambda cell, error: errors.update({cell: str(error)}))
    rows = [
        {"strategy": strategy.name, "sensing": eyes, "mu": mu}
        | assess(cell, outcome(cell, drives[cell]) if cell in drives else None)
        | {"error": errors.get(cell, "")}
        for cell in cells
    ]
    return pd.DataFrame(rows).astype({"contact": "boolean", "r152_passed": "boolean", "windows_passed": "boolean"})


def outcome(cell: Cell, drive: Drive) -> Outcome:
    """What came of a test, from its record."""
    turn = cell.case == "left_turn"
    accel = drive.ego["accel_mps2"].to_numpy()
    end = drive.first(drive.time >= drive.crash_time) + 1 if drive.crashed else len(accel)
    gap = float(np.min(body_distance(drive.ego, drive.target))) if turn and not drive.crashed else drive.final_gap
    return Outcome(
        impact_speed_kmh=drive.impact_speed / KMH,
        warning_ttc=float("nan") if turn else drive.at(drive.ttc, drive.warned),
        min_gap=gap,
        peak_decel=float(np.max(-accel[:end], initial=0.0)),
    )


def assess(cell: Cell, result: Outcome | None) -> dict[str, Any]:
    """Score a test; a score that is not defined for it, or of a test that failed (None), is nan or `pandas.NA`.

    Euro NCAP's bands go by the speed of the tested car, as in its own calculator (see `euroncap_colour`); C-NCAP and UN
    R152 by the relative speed, CCRs and CCRm only. UN R152 is for full overlap only (an offset of at most 0.2 m, from
    memory of the regulation). The windows were printed for CCRm.
    """
    row: dict[str, Any] = {
        "case": cell.case,
        "overlap": cell.overlap,
        "test_speed_kmh": cell.test_speed_kmh,
        "target_speed_kmh": cell.target_speed_kmh,
        "relative_speed_kmh": cell.relative_speed_kmh,
        "contact": pd.NA,
        "impact_speed_kmh": float("nan"),
        "euroncap_colour": "",
        "euroncap_score": float("nan"),
        "cncap_score": float("nan"),
        "cncap_tests_aeb": _cncap_tests_aeb(cell),
        "r152_max_impact_speed_kmh": _r152_limit(cell),
        "r152_passed": pd.NA,
        "warning_ttc_s": float("nan"),
        "min_gap_m": float("nan"),
        "peak_decel_mps2": float("nan"),
        "windows_passed": pd.NA,
    }
    if result is None:
        return row
    impact = result.impact_speed_kmh
    colour = euroncap_colour(
        test_speed_kmh=cell.test_speed_kmh, impact_speed_kmh=impact, avoidance_only=cell.avoidance_only
    )
    row |= {
        "contact": not np.isnan(impact),
        "impact_speed_kmh": impact,
        "euroncap_colour": Colour(int(colour)).name.lower(),
        "euroncap_score": float(euroncap_score(colour)),
        "warning_ttc_s": result.warning_ttc,
        "min_gap_m": result.min_gap,
        "peak_decel_mps2": result.peak_decel,
    }
    if cell.case in _CLOSING_IN:
        row["cncap_score"] = float(cncap_score(test_speed=cell.relative_speed_kmh, impact_speed=impact))
    if not np.isnan(row["r152_max_impact_speed_kmh"]):
        row["r152_passed"] = bool(r152_passes(test_speed_kmh=cell.relative_speed_kmh, impact_speed_kmh=impact))
    if cell.case == "ccrm":
        windows = ccrm_windows(warning_ttc=result.warning_ttc, min_gap=result.min_gap, max_decel=result.peak_decel)
        row["windows_passed"] = bool(windows.passed)
    return row


def points(grid: pd.DataFrame) -> pd.DataFrame:
    """Points per line and, as the last row, of all cells; tests that failed do not count.

    Args:
        grid: as `run_grid` gives it.

    Returns:
        One row per line in the order of the grid, then `all`, by `line`: `cells` that ran, `euroncap_percent` (mean
        score), `cncap_percent` (mean over the cells whose AEB C-NCAP tests; nan for none), `r152_passed` of
        `r152_cells`, `windows_passed` of `windows_cells`.
    """
    lines = [label(case, overlap) for case, overlap in zip(grid["case"], grid["overlap"], strict=True)]
    parts: list[tuple[Hashable, pd.DataFrame]] = [*grid.groupby(lines, sort=False), ("all", grid)]
    return pd.DataFrame([_points(part) for _, part in parts], index=pd.Index([n for n, _ in parts], name="line"))


def label(case: str, overlap: float) -> str:
    """Name of a line: `CCRs 50 %`, `left turn`."""
    if case == "left_turn":
        return "left turn"
    return f"{case[:3].upper()}{case[3:]} {overlap:.0%}".replace("%", " %")


def _points(part: pd.DataFrame) -> dict[str, float]:
    ran = part[part["error"] == ""]
    return {
        "cells": len(ran),
        "euroncap_percent": 100 * ran["euroncap_score"].mean(),
        "cncap_percent": 100 * ran.loc[ran["cncap_tests_aeb"], "cncap_score"].mean(),
        "r152_passed": int(ran["r152_passed"].sum()),
        "r152_cells": int(ran["r152_passed"].count()),
        "windows_passed": int(ran["windows_passed"].sum()),
        "windows_cells": int(ran["windows_passed"].count()),
    }


def _cncap_tests_aeb(cell: Cell) -> bool:
    low, high = _CNCAP_AEB_KMH.get(cell.case, (np.inf, -np.inf))
    return bool(low <= cell.test_speed_kmh <= high)


def _r152_limit(cell: Cell) -> float:
    if cell.case not in _CLOSING_IN or cell.overlap < 1:
        return float("nan")
    return float(r152_max_impact_speed_kmh(cell.relative_speed_kmh))
