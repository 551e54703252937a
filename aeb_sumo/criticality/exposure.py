"""Time spent in danger."""

import numpy as np
from numpy.typing import ArrayLike

from aeb_sumo.soa import Floats
from aeb_sumo.units import G

__all__ = ["EVASIVE", "EXPOSED", "time_below"]

EVASIVE = 0.5 * G
"""Braking above which an encounter without contact is a near-crash [m/s2], from another source: the 100-Car study."""

EXPOSED = 1.5
"""TTC below which traffic counts as in danger [s], from another source: van der Horst 1990; Gettman et al. 2008 (the
default of SSAM)."""


def time_below(value: ArrayLike, threshold: float, *, dt: float) -> Floats:
    """What one step of `dt` adds to the time exposed below a threshold [s]: `dt` or 0.

    Summed over the steps with TTC as value this is the time exposed TTC, TET.
    Source: Minderhoud and Bovy 2001, eq. 3.
    """
    return np.where(np.asarray(value, float) < threshold, dt, 0.0)
