"""Published numbers of Zhao et al. 2025, ids as in shared/seeds.md section 6; tolerances are that table's."""

import numpy as np
import pytest

from aeb_sumo.errors import InputError
from aeb_sumo.fuzzy import RuleBase
from aeb_sumo.strategies.base import Phase
from aeb_sumo.strategies.zhao2025 import Zhao2025, rule_base
from tests.helpers import percept

# id, ego km/h, lead km/h, mu, published critical distance m, of the formula m; end to end: test_reproduction.py
CASES = [
    ("Z10 CCRs 20", 20, 0, 0.85, 5.46, 4.996),
    ("Z10 CCRs 30", 30, 0, 0.85, 8.96, 8.575),
    ("Z11 CCRs 40", 40, 0, 0.85, 13.11, 13.342),
    ("Z12 CCRm 30", 30, 20, 0.85, 4.51, 4.605),
    ("Z12 CCRm 40", 40, 20, 0.85, 6.68, 6.997),
    ("Z12 CCRm 50", 50, 20, 0.85, 10.15, 10.576),
    ("Z13 72 km/h", 72, 0, 0.85, 36.41, 36.569),
    ("Z14 wet 30", 30, 0, 0.5, 11.85, 12.126),
]
IDS = [case[0] for case in CASES]


@pytest.mark.parametrize("case", CASES, ids=IDS)
def test_critical_distance(case):
    _, ego, lead, mu, published, formula = case
    distance = Zhao2025().braking_distance(percept(ego_speed=ego / 3.6, target_speed=lead / 3.6, mu=mu))[0]
    assert distance == pytest.approx(formula, abs=0.001)
    assert distance == pytest.approx(published, abs=0.6)


def test_thresholds_are_latched_when_the_warning_begins():
    system = Zhao2025()
    state, demand = system.step(system.init(1), percept(gap=55.0, ego_speed=20.0), 0.1)  # 72 km/h: 2.8 s
    assert demand.phase[0] == Phase.WARN
    state, demand = system.step(state, percept(gap=44.0, ego_speed=16.0), 0.1)  # 57.6 km/h: TTC 2.75 s
    assert demand.phase[0] == Phase.WARN
    assert state.ttc_threshold[0] == system.ttc_fast


def test_a_braking_lead_needs_more_distance_than_a_steady_one():
    system = Zhao2025()
    steady = system.braking_distance(percept(ego_speed=20.0, target_speed=10.0))[0]
    braking = system.braking_distance(percept(ego_speed=20.0, target_speed=10.0, target_accel=-4.0))[0]
    assert steady == pytest.approx(10 * 0.22 + 10**2 / 13 + 0.36 * 10 + 1.4)
    assert braking == pytest.approx(20 * 0.22 + 20**2 / 13 + 1.4 - 10**2 / 8)
    almost = system.braking_distance(percept(ego_speed=20.0, target_speed=18.0, target_accel=-4.0))[0]
    assert almost == system.braking_distance(percept(ego_speed=20.0, target_speed=18.0))[0], "never less than steady"


def test_level_2_asks_for_all():
    system = Zhao2025()
    _, demand = system.step(system.init(1), percept(gap=3.0, ego_speed=15.0), 0.1)
    assert demand.phase[0] == Phase.FULL_BRAKE
    assert demand.decel[0] == pytest.approx(0.85 * 9.81 - 1)


def test_rules_are_monotone_in_both_directions():
    """Table 5 as printed."""
    rules = rule_base().rules
    assert np.all(np.diff(rules, axis=0) >= 0)
    assert np.all(np.diff(rules, axis=1) <= 0)


def test_a_rule_base_of_the_wrong_shape_is_refused():
    base = rule_base()
    parts = {name: getattr(base, name) for name in RuleBase.__dataclass_fields__}
    with pytest.raises(InputError, match="must be 10 x 9"):
        RuleBase(**parts | {"rules": base.rules[:, :8]})
    with pytest.raises(InputError, match="output sets 0"):
        RuleBase(**parts | {"rules": base.rules + 1})
    with pytest.raises(InputError, match="x_sets must increase"):
        RuleBase(**parts | {"x_sets": base.x_sets[::-1]})
