import numpy as np
import pytest

from aeb_sumo.units import G
from aeb_sumo.vehicle.tyre import Tyre, adhesion, slip_for, tyre_forces

TYRES = [Tyre(), Tyre(eps=2e-4), Tyre(c_x=15.0, c_y=12.0, eps=5e-4)]


def printed(tyre, lam, tan_alpha, load, speed):
    """Eqs. 4-7 as printed, braking force positive, one number at a time."""
    s = np.hypot(tyre.c_x * lam, tyre.c_y * tan_alpha)
    length = (1 - lam) * (1 - tyre.eps * speed * s) / (2 * s)
    f = length * (2 - length) if length < 1 else 1.0
    return load * tyre.c_x * lam / (1 - lam) * f, load * tyre.c_y * tan_alpha / (1 - lam) * f


@pytest.mark.parametrize("tyre", TYRES)
@pytest.mark.parametrize("lam", [-0.3, -0.01, 0.004, 0.03, 0.5])
@pytest.mark.parametrize("tan_alpha", [-0.1, 0.002, 0.05])
def test_forces_are_equations_4_to_7(tyre, lam, tan_alpha):
    along, across = printed(tyre, lam, tan_alpha, 4000.0, 20.0)
    one = np.array([20.0])
    fx, fy = tyre_forces(tyre, slip=np.array([lam]), tan_alpha=tan_alpha, load=np.array([4000.0]), speed=one)
    assert fx[0] == pytest.approx(-along)
    assert fy[0] == pytest.approx(across)


def test_a_rolling_and_a_locked_wheel_are_finite():
    grip = adhesion(Tyre(), slip=np.array([0.0, 1.0]), tan_alpha=0.0, speed=np.array([20.0, 20.0]))
    np.testing.assert_allclose(grip, [1.0, 1 / Tyre().c_x])


def test_grip_never_turns_negative():
    assert adhesion(Tyre(eps=1.0), slip=np.array([0.5]), tan_alpha=0.0, speed=np.array([50.0]))[0] > 0


def test_the_combined_force_stays_within_the_circle_of_friction():
    slip, tan_alpha = np.meshgrid(np.linspace(0.001, 1, 50), np.linspace(-0.5, 0.5, 51))
    fx, fy = tyre_forces(Tyre(c_y=30.0), slip=slip, tan_alpha=tan_alpha, load=np.ones(slip.shape), speed=slip * 0 + 20)
    assert np.hypot(fx, fy).max() <= 1 + 1e-12


def test_braking_with_half_g_takes_two_per_cent_of_slip():
    slip = slip_for(Tyre(), ratio=np.array([-0.5 * G / (0.8 * G)]), speed=np.array([20.0]))
    assert 0.015 < slip[0] < 0.03


@pytest.mark.parametrize("tyre", TYRES)
@pytest.mark.parametrize("speed", [1.0, 14.0, 35.0])
@pytest.mark.parametrize("sign", [-1, 1])
def test_inverse(tyre, speed, sign):
    slips = -sign * np.linspace(0.0, 1.0, 20001)

    def force(slip):
        at = np.full(len(slip), speed)
        return tyre_forces(tyre, slip=slip, tan_alpha=0.0, load=np.ones(len(slip)), speed=at)[0]

    peak = np.abs(force(slips)).max()
    ratio = sign * np.append(np.linspace(0, 0.97, 30) * peak, [0.999 * peak, peak, 1.1, 3.0])
    slip = slip_for(tyre, ratio=ratio, speed=np.full(len(ratio), speed))
    assert np.all(np.abs(slip) <= 1)
    np.testing.assert_allclose(force(slip)[:-4], ratio[:-4], atol=1e-6)
    np.testing.assert_allclose(force(slip)[-4:], sign * np.minimum(np.abs(ratio[-4:]), peak), atol=2e-3)
