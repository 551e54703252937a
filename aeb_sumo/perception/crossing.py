"""Road users whose path crosses the own one: seen by geometry, judged by the time each is where the paths cross."""

from dataclasses import dataclass

import numpy as np

from aeb_sumo.soa import Bools, Floats

__all__ = ["MARGIN", "Approach", "Zone", "conflicting", "crossing_zone"]

MARGIN = 0.3
"""Time to spare between two vehicles passing the same place [s], our assumption."""

_STANDS = 0.3  # m/s, slower than this counts as standing, our assumption
_SAME_WAY = np.cos(np.radians(30))  # within 30 degrees the other is a lead, a matter for following


@dataclass(frozen=True)
class Zone:
    """Where two paths cross: from and to along the own path and along the other's [m]."""

    own_from: float
    own_to: float
    other_from: float
    other_to: float


def crossing_zone(
    points: Floats,
    heading: Floats,
    other_points: Floats,
    other_heading: Floats,
    *,
    width: float,
    spacing: float,
    on_foot: bool = False,
) -> Zone | None:
    """Where two paths come closer than the vehicles are wide while they differ by more than 30 degrees.

    One who goes the same way is a lead, except on foot: SUMO names no pedestrian as one.

    Args:
        points: (n, 2) of the own path [m].
        heading: (n,) of the own path [rad].
        other_points: (m, 2) of the other's [m].
        other_heading: (m,) of the other's [rad].
        width: half the own plus half the other's width [m].
        spacing: distance between the points of either path [m].
        on_foot: the other is a pedestrian, who counts whichever way he goes.

    Returns:
        The first such zone along the own path; None if there is none.
    """
    apart = np.hypot(*(points[:, None, :] - other_points[None, :, :]).transpose(2, 0, 1))
    close = apart < width
    if not on_foot:
        close &= np.cos(heading[:, None] - other_heading[None, :]) < _SAME_WAY
    own, other = np.flatnonzero(close.any(1)), np.flatnonzero(close.any(0))
    if not len(own):
        return None
    return Zone(*(float(spacing * i) for i in (own[0], own[-1], other[0], other[-1])))


@dataclass(frozen=True)
class Approach:
    """Pairs of an ego and another on crossing paths, (n,) each; distances are from the front bumpers [m].

    Attributes:
        to_zone, through_zone: along the own path to where the zone begins (negative inside) and to where it ends.
        speed, length: of the ego [m/s], [m].
        other_to_zone, other_through_zone: the same for the other.
        other_speed, other_accel, other_length: [m/s], [m/s2], [m].
        locked: the ego brakes for this one already.
    """

    to_zone: Floats
    through_zone: Floats
    speed: Floats
    length: Floats
    other_to_zone: Floats
    other_through_zone: Floats
    other_speed: Floats
    other_accel: Floats
    other_length: Floats
    locked: Bools


def conflicting(a: Approach, *, ahead_of: float = MARGIN) -> Bools:
    """Whether both would be in the zone at the same time.

    Both keep their speeds, except that another who brakes goes no farther than it takes to stop. They conflict if the
    ego arrives before the other's tail has left and leaves after the other's front has come, with `MARGIN` to spare.
    For a locked pair the other counts until its tail has left: braking must not argue itself away. Once the ego's front
    is past the middle of the zone, braking no longer helps and there is no conflict.

    Args:
        a: the pairs.
        ahead_of: time to spare in place of `MARGIN` for an ego that leaves before the other comes [s]: braking can only
            harm one who would be through in time, and never one who arrives too late anyway.
    """
    stopping = np.where(a.other_accel < -0.5, a.other_speed**2 / (2 * np.maximum(-a.other_accel, 0.5)), np.inf)
    stands = a.other_speed < _STANDS
    pace = np.maximum(a.other_speed, _STANDS)
    inside = (a.other_to_zone <= 0) & (a.other_through_zone + a.other_length > 0)
    comes = np.where(a.other_to_zone <= 0, 0.0, np.where(stands, np.inf, a.other_to_zone / pace))
    goes = np.where(stands & inside, np.inf, (a.other_through_zone + a.other_length) / pace)

    own = np.maximum(a.speed, 0.1)
    arrives, leaves = np.maximum(a.to_zone, 0.0) / own, (a.through_zone + a.length) / own
    meet = (comes <= leaves + ahead_of) & ((goes >= arrives - MARGIN) | a.locked) & (goes > 0)
    ahead = a.to_zone + a.through_zone > 0
    result: Bools = meet & ahead & (a.other_to_zone <= stopping)
    return result
