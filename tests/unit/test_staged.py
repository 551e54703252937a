import numpy as np
import pytest

from aeb_sumo.strategies.base import Phase
from aeb_sumo.strategies.staged import Staged
from aeb_sumo.strategies.staged_m import StagedM
from tests.helpers import percept

DT = 0.01


def demands(system, gap, closing=5.556, steps=120):
    """Demands at a fixed gap, as if the brake did nothing: only the clock runs."""
    state, out = system.init(1), []
    for _ in range(steps):
        state, demand = system.step(state, percept(gap=gap, ego_speed=closing + 5, target_speed=5.0), DT)
        out.append((int(demand.phase[0]), float(demand.decel[0])))
    return out


def warned_before(system, gap):
    """State after a timely warning, 14 m away."""
    state, demand = system.step(system.init(1), percept(gap=14.0, ego_speed=10.556, target_speed=5.0), DT)
    assert demand.phase[0] == Phase.WARN
    return state


def test_car_n_jabs_then_level_one_then_level_two():
    """1.92, 4.25 held for 0.43 s, 9.54 m/s2 (printed)."""
    system, levels = Staged(), []
    state = warned_before(system, 14.0)
    for _ in range(100):
        state, demand = system.step(state, percept(gap=4.8, ego_speed=10.556, target_speed=5.0), DT)
        levels.append(float(demand.decel[0]))
    values, counts = np.unique(levels, return_counts=True)
    assert values == pytest.approx([1.92, 4.25, 9.54])
    assert counts[:2] * DT == pytest.approx([0.2, 0.43], abs=0.011)
    assert levels == sorted(levels)


def test_a_late_warning_brings_level_one_at_once():
    """Car M at 50 %: warning at TTC 1.75 s and 4.34 m/s2 (printed)."""
    first = demands(StagedM(), gap=9.7)[0]
    assert first == (Phase.PARTIAL_BRAKE, 4.34)


def test_too_little_room_brings_level_two_at_once_and_more():
    phase, decel = demands(Staged(), gap=1.6)[0]
    assert phase == Phase.FULL_BRAKE
    assert decel == 12.0
    phase, decel = demands(Staged(), gap=2.1)[0]
    assert (phase, decel) == (Phase.FULL_BRAKE, pytest.approx(5.556**2 / (2 * 1.5)))


def test_a_lost_target_ends_it_and_level_two_does_not_flicker():
    system = Staged()
    state, demand = system.step(system.init(1), percept(gap=1.6, ego_speed=10.0, target_speed=5.0), DT)
    state, demand = system.step(state, percept(gap=3.0, ego_speed=6.0, target_speed=5.0), DT)
    assert demand.phase[0] == Phase.FULL_BRAKE
    state, demand = system.step(state, percept(gap=3.0, ego_speed=6.0, target_speed=5.0, valid=False), DT)
    assert demand.phase[0] == Phase.NONE
    assert state.braking_for[0] == 0
