"""What a crash does to people: risks of death and of serious injury as functions of speed.

Speeds are in m/s; the sources' curves are in km/h and stand here as they give them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from aeb_sumo.soa import Floats
from aeb_sumo.units import KMH, to_kmh

__all__ = ["ROAD_USERS", "SAME_IMPACT", "death_risk", "serious_risk"]

SAME_IMPACT = KMH
"""Impact speeds that differ by no more are the same [m/s], our assumption."""


@dataclass(frozen=True)
class _Curve:
    """`logit = intercept + per_kmh * v + per_year * age`, and the age that the source's 10 % points are for [years]."""

    intercept: float
    per_kmh: float
    per_year: float
    age: float


# Lubbe, Wu and Jeppsson 2022, Tables 2, 3 and 5, MAIS3+ with the dead: another source, a second-hand transcription in
# public code. At the ages given there it puts the 10 % at 28.8, 43.5 and 113.1 km/h; printed are 29, 44 and 112, within
# what the rounding of the coefficients allows. The motorcyclist's Table 4 was not found: the cyclist's slopes, our
# assumption, through the printed 10 % at 48 km/h.
_CURVES = {
    "pedestrian": _Curve(-6.190, 0.078, 0.038, 46.0),
    "cyclist": _Curve(-7.467, 0.079, 0.047, 39.0),
    "motorcyclist": _Curve(-float(np.log(9)) - 0.079 * 48 - 0.047 * 39, 0.079, 0.047, 39.0),
    "car_driver": _Curve(-7.654, 0.041, 0.021, 39.0),
}
ROAD_USERS = tuple(_CURVES)
"""Those with a curve in `serious_risk`."""


def _logistic(z: Floats) -> Floats:
    return np.exp(-np.logaddexp(0.0, -z))


def death_risk(speed: ArrayLike) -> Floats:
    """Risk that an e-bike rider dies who is hit from the side by the front of a car, 0 to 1.

    `1 / (1 + exp(6.924 - 0.1144 v_kmh))`: from another source, a refit to the points of Hu et al. 2020: 2.9, 23, 50
    and 90 % at 30, 50, 60 and 80 km/h, which it meets within 2 percentage points.

    Args:
        speed: of the car at impact [m/s].
    """
    return _logistic(-6.924 + 0.1144 * to_kmh(np.asarray(speed, float)))


def serious_risk(road_user: str, closing_speed: ArrayLike, *, age: float | None = None) -> Floats:
    """Risk that who is hit by the front of a passenger car is seriously injured (MAIS3+) or dies, 0 to 1.

    Source: Lubbe, Wu and Jeppsson 2022, weighted logistic regressions on German crashes that had injured someone; the
    curve of motorcyclists has its 10 % point from there alone, its slope is our assumption. Below about 10 km/h the
    curves are extrapolated and do not go to 0.

    Args:
        road_user: one of `ROAD_USERS`.
        closing_speed: magnitude of the relative velocity at impact [m/s].
        age: of the person [years]; None for the source's median, 39 (pedestrians 46), from another source.
    """
    curve = _CURVES[road_user]
    years = curve.age if age is None else age
    return _logistic(
        curve.intercept + curve.per_kmh * to_kmh(np.asarray(closing_speed, float)) + curve.per_year * years
    )
