"""What a vehicle's sensors cover."""

from dataclasses import dataclass

import numpy as np

from aeb_sumo.soa import Bools, Floats

__all__ = ["Sensor", "covered"]


@dataclass(frozen=True, kw_only=True)
class Sensor:
    """A forward-looking sensor suite without noise.

    Attributes:
        reach: range [m], our assumption (long-range radar).
        field_of_view: full angle [deg]; 70 from another source (Sui et al. 2021, reference AEB for two-wheelers).
        confirm: a target counts once it has been seen without a gap for this long [s], our assumption.
    """

    reach: float = 150.0
    field_of_view: float = 70.0
    confirm: float = 0.2


def covered(
    sensor: Sensor, *, x: Floats, y: Floats, heading: Floats, target_x: Floats, target_y: Floats
) -> tuple[Bools, Floats]:
    """Whether points lie within range and field of view of sensors at the front bumper.

    Returns:
        (n,) covered, (n,) distance [m].
    """
    dx, dy = target_x - x, target_y - y
    distance = np.hypot(dx, dy)
    ahead = dx * np.cos(heading) + dy * np.sin(heading)
    inside = ahead >= distance * np.cos(np.radians(sensor.field_of_view / 2))
    return inside & (distance <= sensor.reach), distance
