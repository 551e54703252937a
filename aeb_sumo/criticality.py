"""Measures of criticality, one definition each: pure functions of arrays.

`gap` is bumper to bumper [m], `closing_speed` [m/s] and `closing_accel` [m/s2] are positive when the gap shrinks
(faster). Arguments broadcast; "never" is `inf`.
"""

import numpy as np
from numpy.typing import ArrayLike

from aeb_sumo.soa import Floats

__all__ = ["ttc", "ttc2"]


def ttc(*, gap: ArrayLike, closing_speed: ArrayLike) -> Floats:
    """Time to collision at constant speeds [s].

    0 for `gap <= 0` (contact), `inf` when the gap does not shrink.
    Source: Hayward 1972; Zhao et al. 2025, eq. 1.
    """
    gap, closing_speed = np.broadcast_arrays(np.asarray(gap, float), np.asarray(closing_speed, float))
    time = np.full(gap.shape, np.inf)
    with np.errstate(over="ignore"):  # as good as never
        np.divide(gap, closing_speed, out=time, where=closing_speed > 0)
    return np.where(gap <= 0, 0.0, time)


def ttc2(*, gap: ArrayLike, closing_speed: ArrayLike, closing_accel: ArrayLike) -> Floats:
    """Second-order time to collision [s]: constant relative acceleration.

    The smallest positive root of `gap = v t + a t^2 / 2`, in the form `2 gap / (v + sqrt(v^2 + 2 a gap))`, which equals
    the printed one and keeps its precision for small `a`. 0 for `gap <= 0`, `inf` where there is no root.
    Source: Zhao et al. 2025, Table 1. Its rows leave out `v < 0, a > 0` (opening now, closing later); the same root is
    used there.
    """
    gap, v, a = np.broadcast_arrays(*(np.asarray(q, float) for q in (gap, closing_speed, closing_accel)))
    far = np.isinf(gap)  # nothing ahead
    d = np.where(far, 1.0, gap)
    discriminant = v * v + 2 * a * d
    root = np.sqrt(np.maximum(discriminant, 0.0))
    time = np.full(d.shape, np.inf)
    # For v < 0 the sum in the denominator cancels; the other form of the same root does not.
    with np.errstate(over="ignore"):  # as good as never
        np.divide(2 * d, v + root, out=time, where=(discriminant >= 0) & (v >= 0) & (v + root > 0))
        np.divide(root - v, a, out=time, where=(discriminant >= 0) & (v < 0) & (a > 0))
    return np.where(far, np.inf, np.where(d <= 0, 0.0, time))
