"""Measures of criticality where two paths cross.

The zone is where the bodies of both would be in each other's way. A road user enters it with the front and leaves it
with the tail. Times are from now on: 0 for what has happened, `inf` for what never does. At constant speeds they are
`ttc(gap=distance, closing_speed=speed)`, at constant accelerations
`ttc2(gap=distance, closing_speed=speed, closing_accel=accel)`.
"""

import numpy as np
from numpy.typing import ArrayLike

from aeb_sumo.compiled import kernel
from aeb_sumo.criticality.broadcast import over
from aeb_sumo.soa import Floats

__all__ = ["crossing_ttc", "pet", "yielding_decel"]


def crossing_ttc(*, enter: ArrayLike, leave: ArrayLike, other_enter: ArrayLike, other_leave: ArrayLike) -> Floats:
    """Time to collision on crossing paths [s]: until the second enters the zone, if the first is still inside by then.

    0 when both are inside, `inf` when they would not be inside at the same time. It is the same whoever is called the
    other. Source: van der Horst 1990, for approaches at right angles, with the zone in place of the point of collision,
    as in SUMO's SSM device.
    """
    enters = np.maximum(np.asarray(enter, float), np.asarray(other_enter, float))
    leaves = np.minimum(np.asarray(leave, float), np.asarray(other_leave, float))
    return np.where(enters < leaves, enters, np.inf)


def yielding_decel(*, distance: ArrayLike, speed: ArrayLike, until: ArrayLike = np.inf) -> Floats:
    """Smallest constant deceleration that keeps a road user out of a zone until it is free [m/s2].

    `2 (v t - d) / t^2` if the zone is free before a stop in front of it would be complete, else `v^2 / (2 d)`.
    0 for who arrives later anyway, `inf` for who is inside (`distance <= 0`) before it is free.

    Args:
        distance: of the front to the zone, d [m].
        speed: v, >= 0 [m/s].
        until: when the zone is free, t [s]; never by default, and the answer is the deceleration to stop.

    Source: kinematics; the DRAC of SUMO's SSM device for crossing situations.
    """
    return over(_yielding_decel, distance, speed, until)


@kernel
def _yielding_decel(distance: Floats, speed: Floats, until: Floats) -> Floats:
    rate = np.zeros(len(distance))
    for k in range(len(distance)):
        d, v, t = distance[k], speed[k], until[k]
        if t <= 0:
            continue
        if d <= 0:
            rate[k] = np.inf
        elif not (v <= 0 or v * t <= d):
            rate[k] = 2 * (v * t - d) / (t * t) if v * t < 2 * d else v * v / (2 * d)
    return rate


def pet(*, leave: ArrayLike, enter: ArrayLike) -> Floats:
    """Post-encroachment time [s]: from when the first left the zone until the second entered it.

    Negative when the second came before the first was out, `inf` when one of the two never happened.
    Source: Allen, Shin and Cooper 1978.

    Args:
        leave: instant at which the first left [s], `inf` for never.
        enter: instant at which the second entered [s], `inf` for never.
    """
    left, came = np.asarray(leave, float), np.asarray(enter, float)
    both = np.isfinite(left) & np.isfinite(came)
    return np.where(both, np.where(both, came, 0.0) - np.where(both, left, 0.0), np.inf)
