"""Road users that cross the own path: seen by geometry."""

from dataclasses import dataclass

import numpy as np

from aeb_sumo.perception.sensor import Sensor, covered
from aeb_sumo.soa import Bools, Floats

__all__ = ["Ahead", "Others", "conflicts"]

_MARGIN = 0.3  # s, between two vehicles passing the same place, our assumption
_STANDS = 0.3  # m/s, slower than this counts as standing, our assumption
_SAME_WAY = np.cos(np.radians(30))  # within 30 degrees it is a lead, not one that crosses


@dataclass(frozen=True)
class Ahead:
    """The own path ahead, one row per ego: (n, k) points, k samples from the front bumper on.

    Attributes:
        distance: (k,) along the path from the front bumper [m].
        x, y, heading: (n, k) [m], [rad].
        speed, length, width: (n,) of the ego.
    """

    distance: Floats
    x: Floats
    y: Floats
    heading: Floats
    speed: Floats
    length: Floats
    width: Floats


@dataclass(frozen=True)
class Others:
    """The others, (m,) each: front bumper [m], heading [rad], speed, acceleration, length, width."""

    x: Floats
    y: Floats
    heading: Floats
    speed: Floats
    accel: Floats
    length: Floats
    width: Floats


def conflicts(sensor: Sensor, ahead: Ahead, others: Others, locked: Bools) -> Floats:
    """Distance along the own path to where another crosses it at a conflicting time.

    The other goes on straight at its speed; one that brakes goes no farther than it takes to stop. Where the strip it
    sweeps cuts the ego's path, both are there at the same time if the ego, at its speed, arrives before the other's
    tail has left and leaves after the other's front has come, each with 0.3 s to spare (our assumption). For a locked
    pair, one that the ego brakes for, the other counts until its tail has left: braking must not argue itself away.

    Args:
        sensor: what the egos see with, from the front bumper.
        ahead: n egos.
        others: m road users.
        locked: (n, m) pairs for which the ego brakes already.

    Returns:
        (n, m) distance from the front bumper to the place [m], `inf` where there is no conflict.
    """
    cos, sin = np.cos(others.heading), np.sin(others.heading)
    seen, _ = covered(
        sensor,
        x=ahead.x[:, :1],
        y=ahead.y[:, :1],
        heading=ahead.heading[:, :1],
        target_x=(others.x - cos * others.length / 2)[None, :],
        target_y=(others.y - sin * others.length / 2)[None, :],
    )
    result = np.full(seen.shape, np.inf)
    i, j = np.nonzero(seen)
    if not len(i):
        return result
    # One row per pair, one column per sample of the path; along and across are seen from the other.
    dx, dy = ahead.x[i] - others.x[j, None], ahead.y[i] - others.y[j, None]
    cj, sj = cos[j, None], sin[j, None]
    along, across = dx * cj + dy * sj, np.abs(dy * cj - dx * sj)
    turn = ahead.heading[i] - others.heading[j, None]
    half = ahead.width[i, None] / 2
    cut = across <= others.width[j, None] / 2 + half * np.abs(np.cos(turn))
    cut &= np.cos(turn) < _SAME_WAY

    speed, length = others.speed[j, None], others.length[j, None]
    front, tail = along - half * np.abs(np.sin(turn)), along + half * np.abs(np.sin(turn)) + length
    stopping = np.where(
        others.accel[j] < -0.5, others.speed[j] ** 2 / (2 * np.maximum(-others.accel[j], 0.5)), np.inf
    )
    reachable = front <= stopping[:, None]
    stands = speed < _STANDS
    pace = np.maximum(speed, _STANDS)
    comes = np.where(stands, np.where(front <= 0, 0.0, np.inf), np.maximum(front, 0.0) / pace)
    goes = np.where(stands & (tail > 0), np.inf, tail / pace)

    own = np.maximum(ahead.speed[i, None], 0.1)
    arrives = ahead.distance / own
    leaves = (ahead.distance + ahead.length[i, None]) / own
    held = locked[i, j, None]
    meet = (comes <= leaves + _MARGIN) & ((goes >= arrives - _MARGIN) | held) & (tail > 0)
    hit = cut & reachable & meet
    where = hit.argmax(-1)
    result[i, j] = np.where(hit.any(-1), ahead.distance[where], np.inf)
    return result
