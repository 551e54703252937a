"""Accident types of crashes between a car and a two-wheeler, by the GDV catalogue; pure geometry."""

import numpy as np

__all__ = ["typology"]

_ALONG = np.pi / 4
_LEFT, _STRAIGHT = frozenset("lL"), frozenset(("", "s"))


def typology(*, car: float, rider: float, turn: str, rear_end: bool) -> str:
    """The accident type, of those that Yan et al. 2025 name (shared/seeds.md 4.1).

    - `221`: the car turns left, the rider comes towards it.
    - `321`, `322`: the car goes straight on, the rider crosses from the right, from the left.
    - `601`: the car runs into a rider ahead who goes the same way.

    Our reading of the catalogue: headings within 45 deg of each other are the same way, within 45 deg of opposite
    oncoming, the rest crossing; a rider against the lane counts by his heading.

    Args:
        car: heading of the car before the junction [rad], counter-clockwise; outside of one, now.
        rider: the same of the rider.
        turn: of the car in the junction, SUMO's letter; empty outside.
        rear_end: the car's front hit the rear of the rider.

    Returns:
        "221", "321", "322", "601", or empty for any other.
    """
    apart = (rider - car + np.pi) % (2 * np.pi) - np.pi  # positive: the rider goes to the left, so from the right
    if turn in _LEFT:
        return "221" if turn and abs(apart) > np.pi - _ALONG else ""
    if abs(apart) < _ALONG:
        return "601" if rear_end else ""
    if turn in _STRAIGHT and abs(apart) < np.pi - _ALONG:
        return "321" if apart > 0 else "322"
    return ""
