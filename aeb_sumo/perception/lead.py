"""The vehicle ahead on the own path."""

import numpy as np

from aeb_sumo.perception.sensor import covered
from aeb_sumo.soa import Bools, Floats

__all__ = ["sees_lead", "truly_ahead"]


def sees_lead(
    reach: float,
    field_of_view: float,
    *,
    x: Floats,
    y: Floats,
    heading: Floats,
    gap: Floats,
    rear_x: Floats,
    rear_y: Floats,
    lead_heading: Floats,
) -> Bools:
    """Whether a lead that SUMO names is one that a sensor would see there.

    In and before junctions SUMO names leads on other lanes, with a gap to the point where the paths meet. A real
    sensor measures where the vehicle is, so a lead counts only when its rear is in view, it goes the same way (within
    60 degrees) and the gap agrees with the straight distance to its rear, which a curve makes shorter (a chord of a
    quarter circle: 0.9 of the arc).

    Args:
        reach: range of the ego's sensors [m].
        field_of_view: their full angle [deg].
        x: (n,) front bumper of the ego [m].
        y: (n,) front bumper of the ego [m].
        heading: (n,) of the ego [rad].
        gap: (n,) along the lanes, as SUMO gives it, bumper to bumper [m].
        rear_x: (n,) rear bumper of the lead [m].
        rear_y: (n,) rear bumper of the lead [m].
        lead_heading: (n,) of the lead [rad].
    """
    seen, distance = covered(reach, field_of_view, x=x, y=y, heading=heading, target_x=rear_x, target_y=rear_y)
    touching = distance < 2.0  # bumper to bumper the bearing means nothing
    return (seen | touching) & truly_ahead(distance=distance, gap=gap, turned=lead_heading - heading)


def truly_ahead(*, distance: Floats, gap: Floats, turned: Floats) -> Bools:
    """Whether a lead that SUMO names goes the same way and is where its gap says.

    Args:
        distance: (n,) straight, to its rear bumper [m].
        gap: (n,) as in `sees_lead` [m].
        turned: (n,) its heading less the ego's [rad].
    """
    return (np.cos(turned) > 0.5) & (distance <= gap + 1.5) & (distance >= 0.85 * gap - 1.5)
