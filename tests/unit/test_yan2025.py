import numpy as np
import pytest

from aeb_sumo.strategies.base import Phase
from aeb_sumo.strategies.yan2025 import Yan2025
from tests.helpers import percept


def oncoming(turned_deg, x, y, ego=5.556, bike=5.556):
    """An e-bike that comes towards a car turned to the left by so much from the road; x, y in the road's frame [m]."""
    a = np.radians(turned_deg)
    return percept(
        ego_speed=ego, target_speed=0.0, vulnerable=True, gap=y,
        ahead=y * np.cos(a) + x * np.sin(a), left=x * np.cos(a) - y * np.sin(a),
        closing_ahead=ego + bike * np.cos(a), closing_left=-bike * np.sin(a),
    )  # fmt: skip


def test_the_rule_works_in_the_frame_of_the_road():
    """Not turned: never in the lane, 4.8 m aside. Turned by 30 deg: 2.78 m/s sideways, 0.9 s to go."""
    system = Yan2025()
    assert not system.due(oncoming(0, x=4.8, y=8.0), 1.0)[0]
    ahead = 0.9 * (5.556 * np.cos(np.radians(30)) + 5.556)
    assert system.due(oncoming(30, x=2.5, y=ahead), 1.0)[0]
    assert not system.due(oncoming(30, x=2.5, y=ahead), 0.8)[0], "dt1 = 0.9 s"
    assert not system.due(oncoming(30, x=4.8, y=ahead), 1.0)[0], "still 2.3 m aside after 0.9 s, half a lane is 1.9"


def test_lane_entry_compares_the_time_to_enter():
    """|X| - W <= |dVx| T: from 4.8 m to 3.8 m at 2.78 m/s takes 0.36 s."""
    system = Yan2025(rule="lane_entry")
    seen = oncoming(30, x=4.8, y=15.0)
    assert system.due(seen, 0.37)[0]
    assert not system.due(seen, 0.35)[0]
    assert not system.due(oncoming(0, x=4.8, y=15.0), 1.0)[0], "who drives straight on does not enter"


def test_lane_entry_leaves_those_in_peace_who_do_not_enter():
    """A lead that is hardly slower, 120 m ahead; an e-bike 3.5 m aside and far away."""
    system = Yan2025(rule="lane_entry")
    assert not system.due(percept(gap=120.0, ego_speed=20.1, target_speed=20.0), 1.0)[0]
    assert not system.due(oncoming(0, x=3.5, y=100.0), 1.0)[0]
    assert not system.due(oncoming(10, x=3.5, y=100.0), 1.0)[0]


def test_who_has_passed_is_no_matter():
    for rule in ("and", "lane_entry"):
        assert not Yan2025(rule=rule).due(oncoming(30, x=1.0, y=-1.0), 1.0)[0]


@pytest.mark.parametrize(
    ("closing", "vulnerable", "decel"),
    [(3.0, False, 3.0), (6.0, False, 6.0), (15.0, False, 9.0), (3.0, True, 9.0)],
    ids=["slow car", "car", "fast car", "e-bike"],
)
def test_levels(closing, vulnerable, decel):
    """3, 6, 9 m/s2 by relative speed for cars, always 9 for the vulnerable (printed)."""
    system = Yan2025()
    seen = percept(gap=closing * 0.5, ego_speed=closing + 5, target_speed=5.0, vulnerable=vulnerable)
    _, demand = system.step(system.init(1), seen, 0.1)
    assert demand.decel[0] == decel
    assert demand.phase[0] == (Phase.FULL_BRAKE if decel == 9.0 else Phase.PARTIAL_BRAKE)


def test_braking_does_not_weaken_while_the_closing_speed_falls():
    system, seen = Yan2025(), percept(gap=7.0, ego_speed=20.0, target_speed=5.0)
    state, first = system.step(system.init(1), seen, 0.1)
    assert first.decel[0] == 9.0
    state, later = system.step(state, percept(gap=3.0, ego_speed=8.0, target_speed=5.0), 0.1)
    assert later.decel[0] == 9.0
    state, over = system.step(state, percept(gap=3.0, ego_speed=4.0, target_speed=5.0), 0.1)
    assert over.decel[0] == 0.0
    _, again = system.step(state, percept(gap=1.0, ego_speed=8.0, target_speed=5.0), 0.1)
    assert again.decel[0] == 3.0, "another emergency"
