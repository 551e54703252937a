"""Measures of criticality towards what is ahead on the own path."""

import numpy as np
from numpy.typing import ArrayLike

from aeb_sumo.soa import Floats

__all__ = ["drac", "required_decel", "thw", "ttc", "ttc2"]


def _together(*values: ArrayLike) -> tuple[Floats, ...]:
    """As arrays of one shape, which they mostly have."""
    arrays = tuple(np.asarray(q, float) for q in values)
    return arrays if len({q.shape for q in arrays}) == 1 else np.broadcast_arrays(*arrays)


def ttc(*, gap: ArrayLike, closing_speed: ArrayLike) -> Floats:
    """Time to collision at constant speeds [s].

    0 for `gap <= 0` (contact), `inf` when the gap does not shrink.
    Source: Hayward 1972; Zhao et al. 2025, eq. 1.
    """
    gap, closing_speed = _together(gap, closing_speed)
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
    gap, v, a = _together(gap, closing_speed, closing_accel)
    far = np.isinf(gap)  # nothing ahead
    d = np.where(far, 1.0, gap)
    discriminant = v * v + 2 * a * d
    rooted, opens = discriminant >= 0, v < 0
    root = np.sqrt(np.maximum(discriminant, 0.0))
    total = v + root
    time = np.full(d.shape, np.inf)
    # For v < 0 the sum in the denominator cancels; the other form of the same root does not.
    with np.errstate(over="ignore"):  # as good as never
        np.divide(2 * d, total, out=time, where=rooted & ~opens & (total > 0))
        np.divide(root - v, a, out=time, where=rooted & opens & (a > 0))
    return np.where(far, np.inf, np.where(d <= 0, 0.0, time))


def thw(*, gap: ArrayLike, speed: ArrayLike) -> Floats:
    """Time headway [s]: how long the ego takes to where the lead's rear is now.

    From bumper to bumper, what SAE J2944 calls the time gap; a headway from front to front has the lead's length in it.
    0 for `gap <= 0`, `inf` for an ego that stands.
    """
    return ttc(gap=gap, closing_speed=speed)


def drac(*, gap: ArrayLike, closing_speed: ArrayLike) -> Floats:
    """Deceleration rate to avoid a crash [m/s2]: to the lead's speed within the gap, if the lead keeps it.

    `closing_speed^2 / (2 gap)`. 0 when the gap does not shrink, `inf` for `gap <= 0`.
    Source: Cooper and Ferguson 1976; Almqvist et al. 1991. Some print it without the 2, which is no kinematics.
    """
    gap, closing_speed = _together(gap, closing_speed)
    rate = np.zeros(gap.shape)
    with np.errstate(over="ignore"):
        np.divide(closing_speed**2, 2 * gap, out=rate, where=(closing_speed > 0) & (gap > 0))
    return np.where(gap <= 0, np.inf, rate)


def required_decel(*, gap: ArrayLike, speed: ArrayLike, lead_speed: ArrayLike, lead_accel: ArrayLike) -> Floats:
    """Smallest constant deceleration of the ego, from now on, that keeps it off the lead [m/s2].

    The lead keeps its acceleration; a lead that brakes stays where it comes to a stop. If the two would touch at equal
    speeds before the lead stands, the answer is `drac - lead_accel` (`drac` itself at a constant speed of the lead);
    else the ego has to stop within the gap and the lead's stopping distance. 0 when no braking is needed, `inf` for
    `gap <= 0`.

    Args:
        gap: bumper to bumper [m].
        speed: of the ego, >= 0 [m/s].
        lead_speed: >= 0 [m/s].
        lead_accel: signed, negative for a lead that brakes [m/s2].
    """
    g, v, w, a = _together(gap, speed, lead_speed, lead_accel)
    closing, brakes, near = v - w, a < 0, (g > 0) & np.isfinite(g)
    nears = closing > 0
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        moving = np.maximum(closing * closing / (2 * g) - a, 0.0)  # drac, where something closes in
        stops_in, stops_after = np.where(brakes, w / -a, np.inf), np.where(brakes, w * w / (-2 * a), np.inf)
        meets_in = np.where(nears, 2 * g / closing, np.inf)
        standing = v * v / (2 * (g + stops_after))
    rate = np.where(brakes & (meets_in > stops_in), standing, np.where(nears, moving, 0.0))
    return np.where(near, rate, np.where(g <= 0, np.inf, 0.0))
