"""What single sensors cover, and with what probability they detect a target in one frame."""

from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import numpy as np
from scipy.special import ndtr

from aeb_sumo.errors import InputError
from aeb_sumo.soa import Bools, Floats

__all__ = ["Sensor", "cosine_of_half", "covered", "detection", "overlap"]


@dataclass(frozen=True, kw_only=True)
class Sensor:
    """One forward-looking sensor at the front bumper.

    Attributes:
        reach: range [m].
        field_of_view: full angle [deg].
        range_noise: standard deviation of a measured distance [m]; `inf`: it does not measure it.
        rate_noise: of a measured closing speed [m/s]; `inf`: it does not measure it.
        lateral_noise: of a measured lateral offset [m].
        detect: (overlap, range [m]) pairs, overlap rising: where a vehicle of that overlap with the own width is
            detected in every second frame; linear between them.
        sharpness: width of the transition around that range [m], our assumption.
        lost: (from, to) ranges [m] between which a target of at most `lost_overlap` is not seen, our assumption: none.
        lost_overlap: see `lost`, our assumption: none.

    Detection ranges are of the sensor and the target and do not depend on speed, our assumption.
    """

    reach: float
    field_of_view: float
    range_noise: float
    rate_noise: float
    lateral_noise: float
    detect: tuple[tuple[float, float], ...]
    sharpness: float = 0.1
    lost: tuple[float, float] = (0.0, 0.0)
    lost_overlap: float = 0.0

    def __post_init__(self) -> None:
        """Raises `InputError` for a parameter out of range."""
        for name in ("reach", "field_of_view", "range_noise", "lateral_noise", "sharpness"):
            value = getattr(self, name)
            if not 0 < value < np.inf:
                raise InputError(f"Sensor.{name} must be a positive number, not {value:g}")
        if any(b <= a for (a, _), (b, _) in pairwise(self.detect)):
            raise InputError("Sensor.detect must have rising overlaps")


def covered(
    reach: float, field_of_view: float, *, x: Floats, y: Floats, heading: Floats, target_x: Floats, target_y: Floats
) -> tuple[Bools, Floats]:
    """Whether points lie within range [m] and field of view [deg] of a sensor at the front bumper.

    Returns:
        (n,) covered, (n,) distance [m].
    """
    dx, dy = target_x - x, target_y - y
    distance = np.hypot(dx, dy)
    ahead = dx * np.cos(heading) + dy * np.sin(heading)
    inside = ahead >= distance * cosine_of_half(field_of_view)
    return inside & (distance <= reach), distance


@cache
def cosine_of_half(angle: float) -> float:
    """Cosine of half an angle [deg]."""
    return float(np.cos(np.radians(angle / 2)))


def overlap(*, left: Floats, width: Floats, target_width: Floats) -> Floats:
    """Share of the target's width that lies in the own width, 0 to 1, for a target `left` [m] of the own axis."""
    result: Floats = np.clip((width / 2 + target_width / 2 - np.abs(left)) / target_width, 0.0, 1.0)
    return result


def detection(sensor: Sensor, *, distance: Floats, share: Floats) -> Floats:
    """(n,) probability of a detection in one frame, for targets in view at a distance [m] with an overlap `share`."""
    at, ranges = np.array(sensor.detect, float).T
    near, far = sensor.lost
    lost = (share <= sensor.lost_overlap) & (distance >= near) & (distance < far)
    result: Floats = np.where(lost, 0.0, ndtr((np.interp(share, at, ranges) - distance) / sensor.sharpness))
    return result
