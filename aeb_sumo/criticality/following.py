"""Measures of criticality towards what is ahead on the own path."""

import numpy as np
from numpy.typing import ArrayLike

from aeb_sumo.compiled import kernel
from aeb_sumo.criticality.broadcast import over
from aeb_sumo.soa import Floats

__all__ = ["drac", "required_decel", "thw", "time_to_contact", "ttc", "ttc2"]

_BARELY = 1e-9  # m/s2, who brakes by less never stops


def ttc(*, gap: ArrayLike, closing_speed: ArrayLike) -> Floats:
    """Time to collision at constant speeds [s].

    0 for `gap <= 0` (contact), `inf` when the gap does not shrink.
    Source: Hayward 1972; Zhao et al. 2025, eq. 1.
    """
    return over(_ttc, gap, closing_speed)


@kernel
def _ttc(gap: Floats, closing_speed: Floats) -> Floats:
    time = np.empty(len(gap))
    for k in range(len(gap)):
        if gap[k] <= 0:
            time[k] = 0.0
        else:
            time[k] = gap[k] / closing_speed[k] if closing_speed[k] > 0 else np.inf
    return time


def ttc2(*, gap: ArrayLike, closing_speed: ArrayLike, closing_accel: ArrayLike) -> Floats:
    """Second-order time to collision [s]: constant relative acceleration.

    The smallest positive root of `gap = v t + a t^2 / 2`, in the form `2 gap / (v + sqrt(v^2 + 2 a gap))`, which equals
    the printed one and keeps its precision for small `a`. 0 for `gap <= 0`, `inf` where there is no root.
    Source: Zhao et al. 2025, Table 1. Its rows leave out `v < 0, a > 0` (opening now, closing later); the same root is
    used there.
    """
    return over(_ttc2, gap, closing_speed, closing_accel)


@kernel
def _ttc2(gap: Floats, closing_speed: Floats, closing_accel: Floats) -> Floats:
    time = np.full(len(gap), np.inf)
    for k in range(len(gap)):
        d, v, a = gap[k], closing_speed[k], closing_accel[k]
        if np.isinf(d):  # nothing ahead
            continue
        discriminant = v * v + 2 * a * d
        if d <= 0:
            time[k] = 0.0
        elif discriminant >= 0:
            root = np.sqrt(discriminant)
            # For v < 0 the sum in the denominator cancels; the other form of the same root does not.
            if v < 0 and a > 0:
                time[k] = (root - v) / a
            elif v >= 0 and v + root > 0:
                time[k] = 2 * d / (v + root)
    return time


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
    return over(_drac, gap, closing_speed)


@kernel
def _drac(gap: Floats, closing_speed: Floats) -> Floats:
    rate = np.zeros(len(gap))
    for k in range(len(gap)):
        if gap[k] <= 0:
            rate[k] = np.inf
        elif closing_speed[k] > 0 and gap[k] > 0:
            rate[k] = closing_speed[k] * closing_speed[k] / (2 * gap[k])
    return rate


def time_to_contact(
    *, gap: ArrayLike, speed: ArrayLike, accel: ArrayLike, lead_speed: ArrayLike, lead_accel: ArrayLike
) -> Floats:
    """Time to contact [s] if both keep their accelerations, and who brakes stays where he comes to a stop.

    `ttc2`, but that nobody drives backwards. 0 for `gap <= 0`, `inf` for never.

    Args:
        gap: bumper to bumper [m].
        speed: of the ego, >= 0 [m/s].
        accel: of the ego, signed [m/s2].
        lead_speed: along the ego's path [m/s].
        lead_accel: signed [m/s2].
    """
    g, v, a, w, b = np.broadcast_arrays(*(np.asarray(q, float) for q in (gap, speed, accel, lead_speed, lead_accel)))
    brakes = ((s, r, (r < -_BARELY) & (s >= 0)) for s, r in ((v, a), (w, b)))
    stops = [np.divide(s, -r, out=np.full(s.shape, np.inf), where=does) for s, r, does in brakes]
    time, now = np.full(g.shape, np.inf), np.zeros(g.shape)
    for until in (np.minimum(*stops), np.maximum(*stops), np.full(g.shape, np.inf)):
        with np.errstate(invalid="ignore"):  # nobody stops any more
            span = until - now
        meets = ttc2(gap=g, closing_speed=v - w, closing_accel=a - b)
        time = np.where(np.isinf(time) & (meets <= span), now + meets, time)
        passed = np.where(np.isfinite(span), span, 0.0)
        g = g - (v - w) * passed - (a - b) * passed**2 / 2
        v, w = (np.where(until >= stop, 0.0, s + r * passed) for s, r, stop in ((v, a, stops[0]), (w, b, stops[1])))
        a, b = (np.where(until >= stop, 0.0, r) for r, stop in ((a, stops[0]), (b, stops[1])))
        now = until
    return time


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
    return over(_required_decel, gap, speed, lead_speed, lead_accel)


@kernel
def _required_decel(gap: Floats, speed: Floats, lead_speed: Floats, lead_accel: Floats) -> Floats:
    rate = np.zeros(len(gap))
    for k in range(len(gap)):
        g, v, w, a = gap[k], speed[k], lead_speed[k], lead_accel[k]
        if g <= 0:
            rate[k] = np.inf
        if not (g > 0 and np.isfinite(g)):
            continue
        closing = v - w
        meets_in = 2 * g / closing if closing > 0 else np.inf
        if a < 0 and meets_in > w / -a:  # the lead has come to a stop by then
            rate[k] = v * v / (2 * (g + w * w / (-2 * a)))
        elif closing > 0:
            rate[k] = np.maximum(closing * closing / (2 * g) - a, 0.0)
    return rate
