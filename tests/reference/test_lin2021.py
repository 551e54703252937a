"""Thresholds of Lin et al. 2021, eqs. 22 and 23, against shared/seeds.md 2.4; the scenarios: test_reproduction.py."""

import numpy as np
import pytest

from aeb_sumo.strategies.base import Phase
from aeb_sumo.strategies.lin2021 import Lin2021
from aeb_sumo.strategies.lin2021_fixed import Lin2021Fixed
from tests.helpers import percept

# Case: mu, closing speed m/s; eq. 23 TTC_e, eq. 22 TTC_e (a_r -> 0), eq. 23 TTC_w, eq. 22 TTC_w [s].
TABLE = {
    "S1 mu .3": (0.3, 6.944, 1.680, 1.975, 2.566, 2.370),
    "S3 mu .8": (0.8, 8.333, 1.031, 1.164, 1.485, 1.396),
    "S4 mu .3": (0.3, 5.556, 1.444, 1.680, 2.173, 2.016),
    "S4 mu .5": (0.5, 5.556, 1.066, 1.208, 1.544, 1.449),
    "S4 mu .7": (0.7, 5.556, 0.905, 1.006, 1.274, 1.207),
    "S4 mu .8": (0.8, 5.556, 0.854, 0.942, 1.190, 1.131),
}


@pytest.mark.parametrize("case", TABLE)
def test_thresholds(case):
    mu, closing, e23, e22, w23, w22 = TABLE[case]
    seen = percept(ego_speed=closing, target_speed=0.0, mu=mu)
    for system, emergency, warning in ((Lin2021(), e22, w22), (Lin2021(c_emergency=0.5, c_warning=1 / 1.2), e23, w23)):
        got = system.thresholds(seen)
        assert got[1][0] == pytest.approx(emergency, abs=0.001)
        assert got[0][0] == pytest.approx(warning, abs=0.001)


def test_the_longest_reaction_times_give_the_upper_ends():
    """S1: 3.375 s with t1 + t2 = 1.9 s."""
    slow = Lin2021(t1=1.0, t2=0.9, t3=0.3)
    assert slow.thresholds(percept(ego_speed=6.944, mu=0.3))[1][0] == pytest.approx(3.375, abs=0.001)


def test_a_gap_that_opens_in_time_is_no_emergency():
    """The lead pulls away (a_r < 0): they never meet, whatever the threshold."""
    seen = percept(gap=30.0, ego_speed=15.0, target_speed=14.0, target_accel=1.0)
    _, demand = Lin2021().step(Lin2021().init(1), seen, 0.1)
    assert demand.phase[0] == Phase.NONE


def test_slippery_roads_are_braked_on_earlier_and_the_fixed_rival_does_not_know():
    gaps = np.arange(1.0, 40.0, 0.05)

    def trigger(system, mu):
        seen = percept(gap=gaps, ego_speed=12.0, mu=mu)
        return gaps[system.step(system.init(len(gaps)), seen, 0.1)[1].phase == Phase.FULL_BRAKE].max()

    assert trigger(Lin2021(), 0.3) > trigger(Lin2021(), 0.8) + 5
    assert trigger(Lin2021Fixed(), 0.3) == trigger(Lin2021Fixed(), 0.8) == trigger(Lin2021(), 0.8)


def test_the_demand_is_full_friction_until_nothing_closes_in():
    system = Lin2021()
    state, demand = system.step(system.init(1), percept(gap=3.0, ego_speed=12.0, mu=0.5), 0.1)
    assert demand.decel[0] == pytest.approx(0.5 * 9.81)
    state, demand = system.step(state, percept(gap=30.0, ego_speed=5.0, mu=0.4), 0.1)
    assert demand.decel[0] == pytest.approx(0.4 * 9.81), "latched, with the friction as it is known now"
    _, demand = system.step(state, percept(gap=30.0, ego_speed=5.0, target_speed=5.0), 0.1)
    assert demand.phase[0] == Phase.NONE
