"""Measures of criticality, one definition each: pure functions of arrays.

`gap` is bumper to bumper [m], `closing_speed` [m/s] and `closing_accel` [m/s2] are positive when the gap shrinks
(faster), decelerations [m/s2] are magnitudes. Arguments broadcast; "never" is `inf`.
"""

from aeb_sumo.criticality.crossing import crossing_ttc, pet, yielding_decel
from aeb_sumo.criticality.exposure import EVASIVE, EXPOSED, time_below
from aeb_sumo.criticality.following import drac, required_decel, thw, ttc, ttc2

__all__ = [
    "EVASIVE",
    "EXPOSED",
    "crossing_ttc",
    "drac",
    "pet",
    "required_decel",
    "thw",
    "time_below",
    "ttc",
    "ttc2",
    "yielding_decel",
]
