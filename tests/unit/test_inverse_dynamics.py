import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aeb_sumo.units import G
from aeb_sumo.vehicle.inverse_dynamics import (
    Sedan,
    acceleration_of,
    deceleration_of,
    drive_force,
    engine_torque,
    gear_of,
    pressure_of,
    throttle_of,
)

CAR = Sedan()
MASS = CAR.rotating * CAR.mass


def array(x):
    return np.array([x], float)


def resistance(speed):
    return 0.5 * CAR.drag_area * CAR.air_density * speed**2 + CAR.mass * G * CAR.rolling


@given(throttle=st.floats(0, 1), speed=st.floats(0, 60))
def test_throttle_to_acceleration_and_back(throttle, speed):
    accel = acceleration_of(CAR, throttle=array(throttle), speed=array(speed))
    assert throttle_of(CAR, accel=accel, speed=array(speed))[0] == pytest.approx(throttle, abs=1e-9)


@given(decel=st.floats(0, 15), speed=st.floats(0, 60), mu=st.floats(0.05, 1.2))
def test_deceleration_to_pressure_and_back(decel, speed, mu):
    pressure = pressure_of(CAR, decel=array(decel), speed=array(speed), mu=array(mu))
    back = deceleration_of(CAR, pressure=pressure, speed=array(speed), mu=array(mu))[0]
    coasting, limit = resistance(speed) / MASS, (resistance(speed) + mu * CAR.mass * G) / MASS
    assert back == pytest.approx(np.clip(decel, coasting, limit))


def test_equations_8_and_9():
    assert drive_force(CAR, accel=array(1.5), speed=array(20))[0] == pytest.approx(resistance(20) + MASS * 1.5)
    # 20 m/s is fourth gear, and the turbine too fast for the converter to multiply.
    ratio = CAR.gears[3] * CAR.final_drive
    expected = (resistance(20) + MASS * 1.5) * CAR.wheel_radius / (ratio * CAR.efficiency)
    assert engine_torque(CAR, accel=array(1.5), speed=array(20))[0] == pytest.approx(expected)


def test_the_converter_doubles_the_torque_at_standstill():
    ratio = CAR.gears[0] * CAR.final_drive
    expected = (resistance(0) + MASS * 2) * CAR.wheel_radius / (ratio * CAR.efficiency * 2)
    assert engine_torque(CAR, accel=array(2), speed=array(0))[0] == pytest.approx(expected)


def test_gears():
    assert gear_of(CAR, np.array([0.0, 5.9, 6.0, 29.9, 30.0, 70.0])).tolist() == [0, 0, 1, 4, 5, 5]


def test_throttle_ends():
    throttle = throttle_of(CAR, accel=np.array([-5.0, 20.0]), speed=np.array([20.0, 20.0]))
    assert throttle.tolist() == [0.0, 1.0]


def test_more_acceleration_never_needs_less_throttle():
    accel = np.linspace(-2, 8, 200)
    assert np.all(np.diff(throttle_of(CAR, accel=accel, speed=np.full(200, 15.0))) >= 0)


def test_the_sedan_is_plausible():
    assert 3 < acceleration_of(CAR, throttle=array(1), speed=array(5))[0] < 10
    # Throttle to hold 100 km/h, and the speed at which full throttle no longer accelerates.
    assert 0.05 < throttle_of(CAR, accel=array(0), speed=array(100 / 3.6))[0] < 0.3
    assert acceleration_of(CAR, throttle=array(1), speed=array(180 / 3.6))[0] > 0
    assert acceleration_of(CAR, throttle=array(1), speed=array(320 / 3.6))[0] < 0


def test_pressure_is_equation_11():
    pressure = pressure_of(CAR, decel=array(6), speed=array(20), mu=array(0.85))[0]
    assert pressure == pytest.approx((MASS * 6 - resistance(20)) / 3097.26 * 1e6)
    assert 2e6 < pressure < 5e6


def test_no_pressure_where_drag_alone_brakes_enough():
    assert pressure_of(CAR, decel=array(0.1), speed=array(40), mu=array(0.85))[0] == 0.0
    assert deceleration_of(CAR, pressure=array(0), speed=array(40), mu=array(0.85))[0] > 0.1


def test_the_road_limits_the_force():
    pressure = pressure_of(CAR, decel=array(9), speed=array(20), mu=array(0.3))[0]
    assert pressure * CAR.force_per_pressure == pytest.approx(0.3 * CAR.mass * G)
    assert deceleration_of(CAR, pressure=array(2e7), speed=array(20), mu=array(0.3))[0] < 3.1
