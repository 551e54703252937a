"""What protocols give for an outcome: pure functions of arrays; arguments broadcast.

An impact speed is the relative speed at contact; nan or 0 where there was none. Speeds whose protocol has its table in
km/h are in km/h and say so.
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike

from aeb_sumo.soa import Bools, Floats, Ints

__all__ = [
    "Colour",
    "Windows",
    "ccrm_windows",
    "cncap_score",
    "euroncap_colour",
    "euroncap_score",
    "r152_max_impact_speed_kmh",
    "r152_passes",
]


def cncap_score(*, test_speed: ArrayLike, impact_speed: ArrayLike) -> Floats:
    """C-NCAP, CCRs and CCRm: 1 without contact, else the share of the relative speed that was taken away, 0 to 1.

    Both speeds are relative and in the same unit. Source: the sentence on CCRm in the comparison of cars M and N (its
    2.2): full marks without contact, else linear in the reduction of speed (seeds 0.2).

    Args:
        test_speed: relative speed of the test, above 0.
        impact_speed: relative speed at contact.
    """
    test_speed = np.asarray(test_speed, float)
    result: Floats = np.clip((test_speed - _impact(impact_speed)) / test_speed, 0.0, 1.0)
    return result


@dataclass(frozen=True)
class Windows:
    """Verdict per criterion, (n,) each: the value lies within its window."""

    warning_ttc: Bools
    min_gap: Bools
    max_decel: Bools

    @property
    def passed(self) -> Bools:
        """All three do."""
        return self.warning_ttc & self.min_gap & self.max_decel


def ccrm_windows(*, warning_ttc: ArrayLike, min_gap: ArrayLike, max_decel: ArrayLike) -> Windows:
    """How well a contact was avoided in CCRm: windows of safety and comfort, ends included, printed.

    Unknown (nan) values fail. Source: the comparison of cars M and N, 2.2 (seeds 3.1).

    Args:
        warning_ttc: time to collision when the warning began [s]; 2.0 to 4.0 passes.
        min_gap: smallest gap [m]; 0.6 to 2.0 passes.
        max_decel: largest deceleration, >= 0 [m/s2]; up to 10 passes.
    """
    warning_ttc, min_gap, max_decel = (np.asarray(q, float) for q in (warning_ttc, min_gap, max_decel))
    return Windows(
        warning_ttc=(warning_ttc >= 2.0) & (warning_ttc <= 4.0),
        min_gap=(min_gap >= 0.6) & (min_gap <= 2.0),
        max_decel=max_decel <= 10.0,
    )


class Colour(IntEnum):
    """Euro NCAP's colours, best first."""

    GREEN = 0
    """Full score."""
    YELLOW = 1
    """Three quarters."""
    ORANGE = 2
    """Half."""
    BROWN = 3
    """A quarter."""
    RED = 4
    """None."""


_SCORES = np.array([1.0, 0.75, 0.5, 0.25, 0.0])

# Highest impact speed [km/h] of green, yellow, orange and brown; a colour that ends where the one before it ends does
# not exist at that test speed. Rows: tests up to 20, at 30, at 40, from 50 km/h.
_ROW_FROM_KMH = np.array([30.0, 40.0, 50.0])
_UPPER_KMH = np.array([[0.0, 0, 0, 0], [0, 0, 0, 10], [0, 0, 10, 20], [0, 10, 20, 30]])


def euroncap_colour(
    *, test_speed_kmh: ArrayLike, impact_speed_kmh: ArrayLike, avoidance_only: ArrayLike = False
) -> Ints:
    """Euro NCAP 2026: true `Colour` of a test by its impact speed, without tolerance.

    Bands and colours are from another source: Euro NCAP's own calculator, euroncap_rating_2026, which codes the
    protocol Frontal Collisions v1.2, 4.2.4 and 5.2. Test speeds between its multiples of ten take the row below, the
    stricter one, our assumption.

    Args:
        test_speed_kmh: speed of the tested car [km/h].
        impact_speed_kmh: relative speed at contact [km/h].
        avoidance_only: turning and crossing scenarios (CCFtap, CMFtap, CBTA, CPTA, CCCscp, CMCscp): green or red.
    """
    upper = _upper_kmh(test_speed_kmh, avoidance_only)
    result: Ints = np.sum(_impact(impact_speed_kmh)[..., None] > upper, axis=-1)
    return result


def euroncap_score(colour: ArrayLike) -> Floats:
    """Share of the points of a standard-range test for a `Colour`; source as `euroncap_colour`."""
    result: Floats = _SCORES[np.asarray(colour)]
    return result


_R152_TEST_KMH = np.array([40.0, 42, 45, 50, 55, 60])
_R152_IMPACT_KMH = np.array([0.0, 10, 15, 25, 30, 35, np.nan])


def r152_max_impact_speed_kmh(test_speed_kmh: ArrayLike) -> Floats:
    """UN R152, car to car: highest permitted impact speed [km/h] for a relative test speed [km/h]; nan above 60.

    The table is from another source, second-hand (shared/evidence.md). Between its speeds the value of the next higher
    one holds, our assumption (from memory of the regulation).
    """
    return _R152_IMPACT_KMH[np.searchsorted(_R152_TEST_KMH, np.asarray(test_speed_kmh, float))]


def r152_passes(*, test_speed_kmh: ArrayLike, impact_speed_kmh: ArrayLike) -> Bools:
    """UN R152: the impact speed is permitted, both relative [km/h]; False where the table has no value."""
    result: Bools = _impact(impact_speed_kmh) <= r152_max_impact_speed_kmh(test_speed_kmh)
    return result


def _impact(speed: ArrayLike) -> Floats:
    """0 where there was no contact."""
    speed = np.asarray(speed, float)
    return np.where(np.isnan(speed), 0.0, speed)


def _upper_kmh(test_speed_kmh: ArrayLike, avoidance_only: ArrayLike) -> Floats:
    """Highest impact speed of the four colours above red, (..., 4)."""
    row = np.searchsorted(_ROW_FROM_KMH, np.asarray(test_speed_kmh, float), side="right")
    return _UPPER_KMH[np.where(avoidance_only, 0, row)]
