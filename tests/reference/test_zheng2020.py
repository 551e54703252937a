"""Published numbers of Zheng et al. 2020, ids as in shared/seeds.md section 6; the rule base is synthetic (A27)."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from aeb_sumo.errors import InputError
from aeb_sumo.fuzzy import RuleBase
from aeb_sumo.strategies.base import Phase
from aeb_sumo.strategies.zheng2020 import Zheng2020, rule_base
from aeb_sumo.vehicle.brake import brake_init, brake_step
from tests.helpers import percept

DT = 0.01


def ccrs(system, speed_kmh, gap):
    """Point masses and a standing lead, one per speed: when they warn, brake and stop, last gap, peak deceleration."""
    speed = np.array(speed_kmh, float) / 3.6
    gap = np.broadcast_to(np.asarray(gap, float), speed.shape)
    n = len(speed)
    mu, accel, peak = np.full(n, 1.0), np.zeros(n), np.zeros(n)
    warn, brake, stop = (np.full(n, np.inf) for _ in range(3))
    state, actuator = system.init(n), brake_init(system.brake, n, DT)
    for time in np.arange(0, 20, DT):
        state, demand = system.step(state, percept(gap=gap, ego_speed=speed, ego_accel=accel, mu=mu), DT)
        warn = np.minimum(warn, np.where(demand.phase >= Phase.WARN, time, np.inf))
        brake = np.minimum(brake, np.where(demand.phase >= Phase.PARTIAL_BRAKE, time, np.inf))
        actuator, decel = brake_step(system.brake, actuator, demand=demand.decel, mu=mu, dt=DT)
        decel = np.minimum(decel, speed / DT)
        gap = gap - speed * DT + decel * DT**2 / 2
        speed, accel = np.maximum(speed - decel * DT, 0.0), -decel
        peak = np.maximum(peak, decel)
        stop = np.minimum(stop, np.where(speed <= 0, time + DT, np.inf))
    return SimpleNamespace(warn=warn, brake=brake, stop=stop, gap=gap, peak=peak)


def test_thresholds_of_class_1_at_20_kmh():
    """D1: 3.0 s to warn, 1.5 s to brake; the classes differ as seeds 5.3 says."""
    closing = np.array([20 / 3.6])
    assert Zheng2020().warn_threshold(closing) == pytest.approx(3.0, abs=1e-12)
    assert [Zheng2020(driver_class=c).brake_threshold(closing)[0] for c in (1, 2, 3, 4)] == pytest.approx(
        [1.5, 1.35, 1.2, 1.1]
    )


def test_the_worked_example():
    """D1, D3: class 1 at 20 km/h from 30.44 m (A28) warns at 2.48 s, brakes at 3.98 s and stands at 6.58 s."""
    run = ccrs(Zheng2020(), [20], 30.44)
    assert run.warn[0] == pytest.approx(2.48, abs=DT + 1e-9)
    assert run.brake[0] == pytest.approx(3.98, abs=DT + 1e-9)
    assert run.stop[0] - run.brake[0] == pytest.approx(2.60, abs=0.1)
    assert run.peak[0] <= 3.3


@pytest.mark.parametrize("driver_class", [1, 2, 3, 4])
def test_ccrs_of_all_classes(driver_class):
    """D4: final gaps 0.8 to 2.8 m, peaks 1 to 7 m/s2, both +-0.1; no contact."""
    run = ccrs(Zheng2020(driver_class=driver_class), [20, 30, 40], 50.0)
    assert np.all(np.isfinite(run.stop))
    assert np.all((run.gap >= 0.7) & (run.gap <= 2.9))
    assert np.all((run.peak >= 0.9) & (run.peak <= 7.1))


def test_braking_goes_on_until_standstill():
    system = Zheng2020()
    state, demand = system.step(system.init(1), percept(gap=8.0, ego_speed=6.0), 0.1)
    assert demand.phase[0] == Phase.PARTIAL_BRAKE
    state, demand = system.step(state, percept(gap=5.0, ego_speed=1.0), 0.1)  # TTC 5 s
    assert demand.phase[0] == Phase.PARTIAL_BRAKE
    state, demand = system.step(state, percept(gap=4.0, ego_speed=0.0), 0.1)
    assert demand.phase[0] == Phase.NONE
    assert not state.braking[0]


@pytest.mark.parametrize(("value", "said"), [(0, "not 0"), (5, "not 5")])
def test_a_driver_class_out_of_range_is_refused(value, said):
    with pytest.raises(InputError, match=rf"driver_class must be within 1 \.\. 4, {said}"):
        Zheng2020(driver_class=value)


def test_a_bad_file_of_classes_is_refused_at_once(tmp_path):
    with pytest.raises(InputError, match="No such file"):
        Zheng2020(classes_file=str(tmp_path / "none.csv"))


def test_rule_base():
    base = rule_base()
    assert base.rules.shape == (7, 7)
    assert len(base.z_sets) == 7
    assert np.all(np.diff(base.rules, axis=0) >= 0)
    assert np.all(np.diff(base.rules, axis=1) <= 0)
    distance = np.maximum(base.y_sets[:, 0] - 1.305, 0.25)
    wanted = (base.x_sets[:, :1] / 3.6) ** 2 / (2 * distance)
    assert np.array_equal(base.rules, np.abs(wanted[..., None] - base.z_sets[:, 0]).argmin(axis=-1))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rules": rule_base().rules[:, :6]}, r"rules must be 7 x 7, not \(7, 6\)"),
        ({"rules": rule_base().rules + 1}, r"rules must name output sets 0\.\.6, not 7"),
        ({"rules": rule_base().rules - 1}, r"rules must name output sets 0\.\.6, not -1"),
        ({"x_sets": rule_base().x_sets[::-1]}, r"centres of x_sets must increase, not \[60"),
        ({"y_sets": rule_base().y_sets * [1, 0]}, "widths of y_sets must be above 0, not 0"),
        ({"z_sets": np.ones((7, 4))}, r"z_sets must have 2 or 3 columns, not shape \(7, 4\)"),
        ({"x_sets": rule_base().x_sets[:, 0]}, "x_sets must have 2 columns"),
    ],
)
def test_a_rule_base_that_does_not_fit_is_refused(change, message):
    base = rule_base()
    assert isinstance(base, RuleBase)
    with pytest.raises(InputError, match=message):
        replace(base, **change)
