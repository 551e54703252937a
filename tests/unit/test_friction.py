import numpy as np
import pytest

from aeb_sumo.soa import put, take
from aeb_sumo.units import G
from aeb_sumo.vehicle.car import Car, car_init, car_step, normalised_forces, wheel_loads
from aeb_sumo.vehicle.friction import (
    BOUNDS,
    TIE,
    FrictionParams,
    friction_estimate,
    friction_init,
    friction_step,
    informative,
    jacobian,
    reference_filter,
    straight_forces,
)
from aeb_sumo.vehicle.tyre import Tyre

PARAMS, TYRE = FrictionParams(), Tyre()
CAR = PARAMS.car
NONE = np.zeros(1)


def on_the_car(decel, mu, dt=0.01, prior=0.5, speed=25.0):
    """Estimates while the car of three degrees of freedom brakes on `mu`, one friction per step."""
    load = wheel_loads(CAR, accel_x=np.array([-decel]), accel_y=0.0)
    torque = decel * CAR.mass * CAR.wheel_radius * load / load.sum()
    car, state, out = car_init(CAR, np.array([speed])), friction_init(PARAMS, 1, prior), []
    for each in mu:
        car = car_step(CAR, TYRE, car, steer=NONE, brake_torque=torque, mu=np.full((1, 4), each), dt=dt)
        fx, fy = normalised_forces(CAR, TYRE, car, steer=NONE)
        measured = {"accel_x": car.accel_x, "accel_y": car.accel_y, "yaw_accel": car.yaw_accel}
        state = friction_step(PARAMS, state, force_x=fx, force_y=fy, steer=NONE, **measured, dt=dt)
        out.append(friction_estimate(state)[0])
    return np.array(out)


def in_traffic(accel, mu, dt=0.01, prior=0.5, noise=0.0, speed=20.0, state=None):
    """The same from speed and acceleration alone."""
    rng, out = np.random.default_rng(6), []
    state = friction_init(PARAMS, 1, prior) if state is None else state
    for each in mu:
        fx = straight_forces(CAR, TYRE, accel=np.array([accel]), speed=np.array([speed]), mu=np.array([each]))
        ax = accel + noise * rng.normal(size=1)
        zero = {"force_y": np.zeros((1, 4)), "steer": NONE, "accel_y": NONE, "yaw_accel": NONE}
        state = friction_step(PARAMS, state, force_x=fx, accel_x=ax, **zero, dt=dt)
        out.append(friction_estimate(state)[0])
    return np.array(out)


def random_inputs(rng, n):
    fx, fy = rng.normal(0, 2000, (2, n, 4))
    fx[rng.random(n) < 0.4] *= 1e-3  # too little to learn from
    steer, ax, ay, yaw = rng.normal(0, [[0.05], [3], [1], [0.5]], (4, n))
    return {"force_x": fx, "force_y": fy, "steer": steer, "accel_x": ax, "accel_y": ay, "yaw_accel": yaw}


def test_equals_filterpy():
    n, dt, rng = 5, 0.04, np.random.default_rng(2)
    mu = rng.uniform(0.2, 1.0, n)
    state, filters = friction_init(PARAMS, n, mu), [reference_filter(PARAMS, m, dt) for m in mu]
    gated = 0
    for _ in range(80):
        inputs = random_inputs(rng, n)
        state = friction_step(PARAMS, state, **inputs, dt=dt)
        use = informative(PARAMS, inputs["force_x"])
        gated += np.sum(~use)
        rows = jacobian(CAR, force_x=inputs["force_x"], force_y=inputs["force_y"], steer=inputs["steer"])
        for i, f in enumerate(filters):
            h = np.vstack([rows[i], TIE])
            z = np.array([*(inputs[k][i] for k in ("accel_x", "accel_y", "yaw_accel")), 0.0, 0.0])
            have = np.arange(5) >= (0 if use[i] else 3)  # the ties hold without force too
            f.predict()
            f.update(z[have], lambda _, h=h[have]: h, lambda x, h=h[have]: h @ x, R=f.R[np.ix_(have, have)])
    assert 50 < gated < 350
    np.testing.assert_allclose(state.mean, [f.x for f in filters], rtol=1e-9, atol=1e-10)
    np.testing.assert_allclose(state.cov, [f.P for f in filters], rtol=1e-9, atol=1e-12)


def test_braking_straight_shows_two_of_four_without_the_tie_and_all_with_it():
    """The published filter cannot tell front from rear; steady braking only repeats the same rows."""
    seen = []
    for speed in (25.0, 20.0, 15.0):
        fx = straight_forces(CAR, TYRE, accel=np.array([-4.0]), speed=np.array([speed]), mu=np.array([0.8]))
        seen.append(jacobian(CAR, force_x=fx, force_y=0 * fx, steer=NONE)[0])
    assert np.linalg.matrix_rank(np.vstack(seen)) == 2
    assert np.linalg.matrix_rank(np.vstack([*seen, TIE])) == 4


def test_the_jacobian_is_the_derivative_of_the_car_for_small_angles():
    rng = np.random.default_rng(8)
    fx, fy = rng.normal(0, 3000, (2, 1, 4))
    d, mu = 0.02, rng.uniform(0.3, 1.0, 4)
    (fl, fr, rl, rr), (gl, gr, hl, hr) = mu * fx[0], mu * fy[0]
    ax = (fl + fr - (gl + gr) * d + rl + rr) / CAR.mass
    ay = ((fl + fr) * d + gl + gr + hl + hr) / CAR.mass
    tf, tr = CAR.track_front / 2, CAR.track_rear / 2
    moment = (
        CAR.a * ((fl + fr) * d + gl + gr) - CAR.b * (hl + hr) + tf * (gl - gr) * d - tf * (fl - fr) - tr * (rl - rr)
    )
    rows = jacobian(CAR, force_x=fx, force_y=fy, steer=np.array([d]))[0]
    np.testing.assert_allclose(rows @ mu, [ax, ay, moment / CAR.yaw_inertia])


@pytest.mark.parametrize("run", [lambda mu: on_the_car(3.0, mu), lambda mu: in_traffic(-3.0, mu)])
def test_l14_mu_08_and_a_joint_from_08_to_05(run):
    estimate = run([0.8] * 50 + [0.5] * 50)
    assert np.all(np.abs(estimate[10:50] - 0.8) < 0.05)
    assert np.all(np.abs(estimate[70:] - 0.5) < 0.05)


@pytest.mark.parametrize("dt", [0.04, 0.1])
def test_l14_holds_for_the_steps_of_traffic(dt):
    steps = round(1 / dt)
    estimate = in_traffic(-3.0, [0.8] * steps + [0.5] * steps, dt=dt)
    assert np.all(np.abs(estimate[2:steps] - 0.8) < 0.05)
    assert np.all(np.abs(estimate[steps + int(0.2 / dt) :] - 0.5) < 0.05)


@pytest.mark.parametrize("mu", [0.2, 0.5, 0.8, 1.0])
@pytest.mark.parametrize("share", [0.3, 0.9, 1.0])
def test_up_to_the_peak_of_the_tyre_the_estimate_is_right(mu, share):
    assert in_traffic(-share * mu * G, [mu] * 30)[-1] == pytest.approx(mu, abs=0.05)


def test_locked_wheels_tell_friction_too():
    assert on_the_car(12.0, [0.5] * 60, prior=0.8)[-1] == pytest.approx(0.5, abs=0.02)


def test_it_learns_from_driving_too():
    assert in_traffic(2.0, [0.8] * 50)[-1] == pytest.approx(0.8, abs=0.05)


def test_with_noise_it_is_right_on_average():
    estimate = in_traffic(-3.0, [0.8] * 500, noise=PARAMS.sigma_accel)[50:]
    assert estimate.mean() == pytest.approx(0.8, abs=0.01)
    assert np.all(np.abs(estimate - 0.8) < 0.05)


@pytest.mark.parametrize("accel", [0.0, -0.05, 0.05])
def test_cruising_teaches_nothing(accel):
    np.testing.assert_allclose(in_traffic(accel, [0.3] * 1000, prior=0.8, noise=0.05), 0.8, rtol=1e-9)


def test_after_a_long_cruise_the_first_braking_tells_at_once():
    state = friction_init(PARAMS, 1, 0.8)
    quiet = dict.fromkeys(("steer", "accel_x", "accel_y", "yaw_accel"), NONE)
    for _ in range(1000):
        state = friction_step(PARAMS, state, force_x=np.zeros((1, 4)), force_y=np.zeros((1, 4)), **quiet, dt=0.1)
    assert in_traffic(-2.0, [0.3], dt=0.1, state=state)[0] == pytest.approx(0.3, abs=0.05)


def test_standing_still_teaches_nothing():
    assert not straight_forces(CAR, TYRE, accel=np.array([-3.0]), speed=NONE, mu=np.array([0.8])).any()


def test_the_estimate_is_bounded():
    for mu, bound in ((3.0, BOUNDS[1]), (-1.0, BOUNDS[0])):
        assert friction_estimate(friction_init(PARAMS, 2, mu)) == pytest.approx([bound] * 2)


def test_halving_the_step_changes_little():
    estimates = [
        in_traffic(-1.0, [0.8] * round(0.4 / dt), dt=dt)[round(0.05 / dt) - 1 :: round(0.05 / dt)]
        for dt in (0.01, 0.005)
    ]
    np.testing.assert_allclose(*estimates, atol=0.005)


def test_forces_in_traffic_bring_the_acceleration_about():
    accel, mu = np.array([-6.0, -1.0, 2.0]), np.array([0.8, 0.4, 0.9])
    fx = straight_forces(CAR, TYRE, accel=accel, speed=np.full(3, 15.0), mu=mu)
    np.testing.assert_allclose(mu * fx.sum(axis=1) / CAR.mass, accel)


def test_a_batch_equals_the_singles_and_inputs_stay():
    rng, n = np.random.default_rng(9), 6
    state, inputs = friction_init(PARAMS, n, rng.uniform(0.2, 1, n)), random_inputs(rng, n)
    before = {k: v.copy() for k, v in inputs.items()}
    together = friction_step(PARAMS, state, **inputs, dt=0.04)
    apart = friction_init(PARAMS, n, 0.0)
    for i in range(n):
        row = np.array([i])
        alone = friction_step(PARAMS, take(state, row), **{k: v[row] for k, v in inputs.items()}, dt=0.04)
        put(apart, row, alone)
    np.testing.assert_allclose(apart.mean, together.mean, rtol=1e-12)
    np.testing.assert_allclose(apart.cov, together.cov, rtol=1e-9, atol=1e-15)
    for k, v in inputs.items():
        np.testing.assert_array_equal(v, before[k])


def test_another_car_is_believed_in():
    heavy = FrictionParams(car=Car(mass=2500.0))
    assert not informative(heavy, np.full((1, 4), 100.0))[0]
    assert informative(PARAMS, np.full((1, 4), 100.0))[0]
