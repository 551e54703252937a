"""The vehicle ahead on the own path."""

from math import sqrt

import numpy as np

from aeb_sumo.compiled import kernel
from aeb_sumo.perception.sensor import cosine_of_half
from aeb_sumo.soa import Bools, Floats, Ints

__all__ = ["sees_lead", "truly_ahead"]

_SAME_WAY = 0.5  # cosine of 60 degrees
_CHORD, _LONGER = 0.85, 1.5  # how much shorter than the gap a straight distance can be, and how much else [m]
_TOUCHING = 2.0  # m, bumper to bumper the bearing means nothing


def sees_lead(
    reach: float,
    field_of_view: float,
    *,
    ego: Ints,
    lead: Ints,
    gap: Floats,
    x: Floats,
    y: Floats,
    heading: Floats,
    length: Floats,
) -> Bools:
    """Whether a lead that SUMO names is one that a sensor would see there.

    In and before junctions SUMO names leads on other lanes, with a gap to the point where the paths meet. A real
    sensor measures where the vehicle is, so a lead counts only when its rear is in view, it goes the same way (within
    60 degrees) and the gap agrees with the straight distance to its rear, which a curve makes shorter (a chord of a
    quarter circle: 0.9 of the arc).

    Args:
        reach: range of the ego's sensors [m].
        field_of_view: their full angle [deg].
        ego: (n,) row of the ego in the arrays of all vehicles.
        lead: (n,) row of the lead.
        gap: (n,) along the lanes, as SUMO gives it, bumper to bumper [m].
        x: (m,) front bumpers of all vehicles [m].
        y: (m,) front bumpers of all vehicles [m].
        heading: (m,) of all vehicles [rad].
        length: (m,) of all vehicles [m].

    Returns:
        (n,) whether it counts.
    """
    own, its = heading[ego], heading[lead]
    return _sees_lead(
        reach, cosine_of_half(field_of_view), ego, lead, gap, x, y, length,
        np.cos(own), np.sin(own), np.cos(its), np.sin(its), np.cos(its - own),
    )  # fmt: skip


@kernel
def _sees_lead(
    reach: float, cosine: float, ego: Ints, lead: Ints, gap: Floats, x: Floats, y: Floats, length: Floats,
    cos: Floats, sin: Floats, lead_cos: Floats, lead_sin: Floats, same_way: Floats,
) -> Bools:  # fmt: skip
    result = np.empty(len(ego), np.bool_)
    for k in range(len(ego)):
        i, j = ego[k], lead[k]
        dx, dy = x[j] - length[j] * lead_cos[k] - x[i], y[j] - length[j] * lead_sin[k] - y[i]
        distance = sqrt(dx * dx + dy * dy)
        seen = dx * cos[k] + dy * sin[k] >= distance * cosine and distance <= reach
        touching = distance < _TOUCHING
        result[k] = (seen or touching) and _truly_ahead(distance, gap[k], same_way[k])
    return result


def truly_ahead(*, distance: Floats, gap: Floats, turned: Floats) -> Bools:
    """Whether a lead that SUMO names goes the same way and is where its gap says.

    Args:
        distance: (n,) straight, to its rear bumper [m].
        gap: (n,) as in `sees_lead` [m].
        turned: (n,) its heading less the ego's [rad].
    """
    return (np.cos(turned) > _SAME_WAY) & (distance <= gap + _LONGER) & (distance >= _CHORD * gap - _LONGER)


@kernel
def _truly_ahead(distance: float, gap: float, same_way: float) -> bool:
    return same_way > _SAME_WAY and distance <= gap + _LONGER and distance >= _CHORD * gap - _LONGER
