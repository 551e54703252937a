import numpy as np
import pytest

from aeb_sumo.units import G
from aeb_sumo.vehicle.brake import BrakeParams, brake_init, brake_step, pid_step


def respond(params, demand, steps, dt=0.01, mu=0.85):
    state, out = brake_init(params, 1, dt), []
    for _ in range(steps):
        state, decel = brake_step(params, state, demand=np.array([demand]), mu=np.array([mu]), dt=dt)
        out.append(decel[0])
    return np.array(out)


def test_reaches_the_demand_and_stays():
    assert respond(BrakeParams(), 5.0, 200)[-1] == pytest.approx(5.0, abs=1e-3)


def test_dead_time_comes_first():
    response = respond(BrakeParams(dead_time=0.1), 5.0, 40)
    assert np.all(response[:10] == 0)
    assert response[10] > 0


def test_build_up_is_limited():
    response = respond(BrakeParams(dead_time=0, build_up=20.0), 8.0, 60)
    assert np.max(np.diff(response)) <= 20.0 * 0.01 + 1e-9


def test_without_dead_time_the_loop_has_the_lag_of_the_plant():
    params = BrakeParams(dead_time=0.0, lag=0.05, build_up=np.inf, release=np.inf)
    response = respond(params, 6.0, 100)
    assert np.argmax(response >= 6.0 * (1 - np.exp(-1))) * 0.01 == pytest.approx(0.05, abs=0.015)
    assert response.max() <= 6.0 * 1.02


@pytest.mark.parametrize("mu", [0.2, 0.5, 0.85])
def test_friction_limits(mu):
    assert respond(BrakeParams(), 12.0, 200, mu=mu)[-1] == pytest.approx(mu * G, rel=1e-3)


def test_the_mean_over_a_long_step_is_that_of_short_ones():
    params = BrakeParams()
    assert respond(params, 5.0, 1, dt=0.1)[0] == pytest.approx(respond(params, 5.0, 10, dt=0.01).mean())


def test_dead_time_by_friction():
    """0 s on 0.3, 0.2 s on 0.8, linear between them."""
    params = BrakeParams(
        dead_time_by_mu=((0.3, 0.0), (0.8, 0.2)), lag=0.0, build_up=np.inf, release=np.inf, open_loop=True
    )
    for mu, steps in ((0.3, 0), (0.55, 10), (0.8, 20), (1.0, 20)):
        assert np.argmax(respond(params, 2.0, 40, mu=mu) > 0) == steps


def test_without_a_controller_a_fall_comes_through_at_once():
    params = BrakeParams(dead_time=0.3, lag=0.0, build_up=np.inf, release=np.inf, open_loop=True)
    state, ones = brake_init(params, 1, 0.01), np.ones(1)
    for _ in range(60):
        state, decel = brake_step(params, state, demand=5 * ones, mu=ones, dt=0.01)
    assert decel[0] == 5.0
    _, decel = brake_step(params, state, demand=0 * ones, mu=ones, dt=0.01)
    assert decel[0] < 5.0


def test_pid_is_equation_7():
    out, integral = pid_step(error=2.0, last=0.0, integral=0.0, kp=2.0, ti=0.5, td=0.1, limit=100.0, dt=0.1)
    assert out == pytest.approx(2.0 * (2.0 + 0.2 / 0.5 + 0.1 * 2.0 / 0.1))
    assert integral == pytest.approx(0.2)


def test_pid_does_not_wind_up():
    integral = 0.0
    for _ in range(100):
        out, integral = pid_step(error=3.0, last=3.0, integral=integral, kp=1.0, ti=0.05, td=0.0, limit=5.0, dt=0.01)
    assert out == 5.0
    assert integral < 1.0
