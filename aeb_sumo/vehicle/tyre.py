"""The normalised Dugoff tyre of Lin et al. 2021, eqs. 4-7, and its inverse in straight running.

Slip is positive in braking, `lam = (v - w R) / v`, as eqs. 4 and 7 need it; eq. 9 prints the opposite sign. The same
equations hold for driving, with negative slip. Forces are in the axes of the wheel, forward and left positive, as
eqs. 1-3 need them; eq. 4 prints the braking force as positive.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from aeb_sumo.parameters import check, within
from aeb_sumo.soa import Floats

__all__ = ["Tyre", "adhesion", "slip_for", "tyre_forces"]


@dataclass(frozen=True, kw_only=True)
class Tyre:
    """Parameters of the tyre; the source gives none.

    Attributes:
        c_x: slip stiffness per load and friction [-], our assumption: braking with 0.5 g on mu 0.8 takes 2.2 % slip.
        c_y: cornering stiffness per load and friction [1/rad], our assumption.
        eps: loss of grip with sliding speed [s/m], 0, our assumption: then the peak force is mu times the load, and
            `mu g` is what a straight braking car can reach, here as in `vehicle.brake`. It multiplies stiffness times
            slip, so that the customary 0.015 s/m, which multiplies slip alone, corresponds to `0.015 / c_x`.
    """

    c_x: float = 30.0
    c_y: float = 20.0
    eps: float = within(0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        """Raises `InputError` for a parameter out of range."""
        check(self, positive=True)


_LEAST_GRIP = 0.05  # 1 - eps v S does not fall below, our assumption
_MOST_DRIVING = 0.5  # of c_x: the stretched slip lam / (1 - lam) at slip -1, a wheel turning at twice its speed


def adhesion(tyre: Tyre, *, slip: Floats, tan_alpha: ArrayLike, speed: Floats) -> Floats:
    """`f(L) / (1 - lam)` of eqs. 4-7 [-]: how much of its stiffness the tyre has left.

    Finite for a locked wheel (slip 1) and 1 without slip, where L is infinite.

    Args:
        tyre: parameters.
        slip: longitudinal slip, positive in braking, <= 1 [-].
        tan_alpha: tangent of the slip angle [-].
        speed: of the car [m/s].
    """
    s = np.hypot(tyre.c_x * slip, tyre.c_y * np.asarray(tan_alpha))
    grip = np.maximum(1 - tyre.eps * speed * s, _LEAST_GRIP)
    sliding = (1 - slip) * grip < 2 * s  # L < 1
    half = grip / np.where(sliding, 2 * s, 1.0)  # L / (1 - lam)
    return np.where(sliding, half * (2 - half * (1 - slip)), 1 / np.where(sliding, 1.0, 1 - slip))


def tyre_forces(
    tyre: Tyre, *, slip: Floats, tan_alpha: ArrayLike, load: Floats, speed: Floats
) -> tuple[Floats, Floats]:
    """Normalised forces `Fx0` forward and `Fy0` to the left [N] (eqs. 4-5): mu times them acts on the car.

    Args:
        tyre: parameters.
        slip: longitudinal slip, positive in braking, <= 1 [-].
        tan_alpha: tangent of the slip angle, positive when the tyre pushes to the left [-].
        load: vertical force, >= 0 [N].
        speed: of the car [m/s].
    """
    grip = load * adhesion(tyre, slip=slip, tan_alpha=tan_alpha, speed=speed)
    return -tyre.c_x * slip * grip, tyre.c_y * np.asarray(tan_alpha) * grip


def slip_for(tyre: Tyre, *, ratio: Floats, speed: Floats) -> Floats:
    """The slip that brings about a wanted normalised force in straight running: the inverse of eqs. 4, 6 and 7.

    With `u = c_x lam / (1 - lam)` and `e = 1 - eps v c_x lam` the force per load is `u` up to `e / 2` and
    `e - e^2 / (4 u)` beyond, which is solved for `u`; `e` itself follows by iteration, from below.

    Args:
        tyre: parameters.
        ratio: normalised force per load, `Fx0 / Fz`, forward positive [-].
        speed: of the car [m/s].

    Returns:
        Slip, positive in braking, -1 to 1 [-]. Where the tyre cannot give the force, the slip at its peak.
    """
    wanted, sign = np.abs(ratio), -np.sign(ratio)
    fade = tyre.eps * speed * tyre.c_x
    # Where the derivative of the force is zero, but for a term of third order in the slip.
    peak = 1 / np.sqrt(np.maximum(fade * (4 * tyre.c_x + 2 * sign + fade), 1.0))
    slip = np.zeros_like(wanted)
    for _ in range(40 if tyre.eps else 1):
        e = np.maximum(1 - fade * slip, _LEAST_GRIP)
        u = np.where(wanted <= e / 2, wanted, e * e / (4 * np.maximum(e - wanted, 1e-12)))
        u = np.where(sign < 0, np.minimum(u, _MOST_DRIVING * tyre.c_x), u)
        slip = np.minimum(u / (tyre.c_x + sign * u), peak)
    return sign * slip
