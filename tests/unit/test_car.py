import numpy as np
import pytest

from aeb_sumo.units import G
from aeb_sumo.vehicle.car import Car, car_init, car_step, normalised_forces, wheel_loads
from aeb_sumo.vehicle.tyre import Tyre

CAR, TYRE, DT = Car(), Tyre(), 0.01


def torques(decel):
    """Brake torques for a deceleration [m/s2], (n, 4), split as the loads are under it."""
    decel = np.atleast_1d(decel)
    share = wheel_loads(CAR, accel_x=-decel, accel_y=0.0) / (CAR.mass * G)
    return decel[:, None] * CAR.mass * CAR.wheel_radius * share


def drive(speed, torque, mu, steps, steer=0.0, dt=DT, tyre=TYRE):
    """States after every step of one car."""
    state, out = car_init(CAR, np.array([speed])), []
    torque, mu = (np.broadcast_to(np.asarray(q, float), (1, 4)) for q in (torque, mu))
    for _ in range(steps):
        state = car_step(CAR, tyre, state, steer=np.array([steer]), brake_torque=torque, mu=mu, dt=dt)
        out.append(state)
    return out


def mean_decel(states, after=20):
    return (states[after].speed_x[0] - states[-1].speed_x[0]) / ((len(states) - 1 - after) * DT)


def test_loads_are_equation_8():
    ax, ay, base = -3.0, 2.0, CAR.a + CAR.b
    load = wheel_loads(CAR, accel_x=np.array([ax]), accel_y=np.array([ay]))[0]
    lift = CAR.mass * ay * CAR.cog_height / CAR.track_front
    pitch = CAR.mass * ax * CAR.cog_height / (2 * base)
    assert load[0] == pytest.approx((CAR.mass * G / 2 - lift) * CAR.b / base - pitch)
    assert load[3] == pytest.approx((CAR.mass * G / 2 + lift) * CAR.a / base + pitch)
    assert load.sum() == pytest.approx(CAR.mass * G)


@pytest.mark.parametrize("mu", [0.3, 0.8])
@pytest.mark.parametrize("share", [0.3, 0.8])
def test_below_the_limit_the_car_decelerates_as_the_torques_say(mu, share):
    torque = torques(share * mu * G)
    decel = mean_decel(drive(20.0, torque, mu, 100))
    assert decel == pytest.approx(torque.sum() / (CAR.mass * CAR.wheel_radius), rel=0.04)
    inertia = CAR.mass + 4 * CAR.wheel_inertia / CAR.wheel_radius**2  # the wheels are braked too
    assert decel == pytest.approx(torque.sum() / (inertia * CAR.wheel_radius), rel=0.01)


@pytest.mark.parametrize("mu", [0.3, 0.8])
def test_above_the_limit_the_wheels_lock_and_the_car_decelerates_with_mu_g(mu):
    states = drive(20.0, 1.5 * torques(mu * G), mu, 100)
    assert np.all(states[-1].spin == 0)
    assert mean_decel(states) == pytest.approx(mu * G, rel=0.02)


def test_just_below_the_limit_the_wheels_turn():
    states = drive(20.0, torques(0.95 * 0.8 * G), 0.8, 100)
    assert np.all(states[-1].spin > 0)
    assert mean_decel(states) == pytest.approx(0.95 * 0.8 * G, rel=0.04)


def test_it_stops_and_stays():
    states = drive(5.0, torques(6.0), 0.8, 150)
    assert states[-1].speed_x[0] == pytest.approx(0, abs=1e-6)
    assert np.all(states[-1].spin == 0)
    assert np.all(np.diff([s.speed_x[0] for s in states]) <= 1e-12)


def test_rolling_freely_it_keeps_its_speed():
    assert drive(20.0, 0.0, 0.8, 100)[-1].speed_x[0] == pytest.approx(20.0)


def test_negative_torque_drives():
    assert mean_decel(drive(10.0, torques(-2.0), 0.8, 100)) == pytest.approx(-2.0, rel=0.04)


def test_a_symmetric_car_stays_straight():
    last = drive(25.0, torques(7.0), 0.8, 100)[-1]
    assert abs(last.yaw_rate[0]) + abs(last.speed_y[0]) < 1e-9


@pytest.mark.parametrize(("mu", "sign"), [([0.8, 0.3, 0.8, 0.3], 1), ([0.3, 0.8, 0.3, 0.8], -1)])
def test_on_split_friction_it_yaws_to_the_side_that_grips(mu, sign):
    assert drive(20.0, torques(6.0), mu, 30)[-1].yaw_rate[0] * sign > 0.02


def test_in_a_steady_turn_it_follows_the_single_track_model():
    v, steer = 15.0, 0.01
    last = drive(v, 0.0, 0.8, 200, steer=steer)[-1]
    base, stiffness = CAR.a + CAR.b, TYRE.c_y * 0.8 * CAR.mass * G / 2  # loads of the axles are in balance, b and a
    front, rear = (stiffness * 2 * arm / base for arm in (CAR.b, CAR.a))
    understeer = CAR.mass / base * (CAR.b / front - CAR.a / rear)
    assert last.yaw_rate[0] == pytest.approx(v * steer / (base + understeer * v**2), rel=0.02)
    assert last.accel_y[0] == pytest.approx(v * last.yaw_rate[0], rel=0.02)


def test_measured_forces_times_mu_are_the_measured_accelerations():
    for state in (drive(20.0, torques(6.0), [0.8, 0.6, 0.8, 0.6], 40)[-1], drive(20.0, torques(3.0), 0.8, 40)[-1]):
        mu = [0.8, 0.6, 0.8, 0.6] if state.yaw_rate[0] else 0.8
        fx, _ = normalised_forces(CAR, TYRE, state, steer=np.zeros(1))
        assert (mu * fx).sum() / CAR.mass == pytest.approx(state.accel_x[0], rel=0.01)


def test_a_batch_equals_the_singles_and_a_step_equals_its_halves():
    speeds, decels = np.array([8.0, 20.0, 30.0]), np.array([2.0, 6.0, 12.0])
    mu, steer = np.full((3, 4), 0.7), np.array([0.0, 0.01, -0.01])
    whole = half = car_init(CAR, speeds)
    torque = np.concatenate([torques(d) for d in decels])
    for _ in range(20):
        whole = car_step(CAR, TYRE, whole, steer=steer, brake_torque=torque, mu=mu, dt=0.02)
    for _ in range(40):
        half = car_step(CAR, TYRE, half, steer=steer, brake_torque=torque, mu=mu, dt=0.01)
    np.testing.assert_allclose(whole.speed_x, half.speed_x)
    np.testing.assert_allclose(whole.yaw_rate, half.yaw_rate, atol=1e-12)
    for i in range(3):
        last = drive(speeds[i], torque[i], 0.7, 40, steer=steer[i])[-1]
        np.testing.assert_allclose(last.speed_x[0], half.speed_x[i])
        np.testing.assert_allclose(last.spin[0], half.spin[i], atol=1e-9)


def test_the_step_of_integration_matters_little():
    fine = Car(substep=0.0001)
    coarse, precise = car_init(CAR, np.array([10.0])), car_init(fine, np.array([10.0]))
    inputs = {"steer": np.array([0.01]), "brake_torque": torques(5.0), "mu": np.full((1, 4), 0.8), "dt": DT}
    for _ in range(50):
        coarse, precise = car_step(CAR, TYRE, coarse, **inputs), car_step(fine, TYRE, precise, **inputs)
    assert coarse.speed_x[0] == pytest.approx(precise.speed_x[0], rel=2e-3)
    assert coarse.yaw_rate[0] == pytest.approx(precise.yaw_rate[0], rel=1e-2)
