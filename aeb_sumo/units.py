"""Constants and conversions for the edges; inside, everything is SI."""

from aeb_sumo.soa import Floats

__all__ = ["KMH", "G", "to_kmh"]

G = 9.81
"""Gravity [m/s2]."""

KMH = 1 / 3.6
"""One km/h [m/s]: `50 * KMH`."""


def to_kmh(speed: Floats) -> Floats:
    """Speed [m/s] -> [km/h]."""
    return speed * 3.6
