"""Which vehicles meet, told from arrays of the world."""

import numpy as np
import pytest

from aeb_sumo.ledger.encounters import crossing, following
from aeb_sumo.world.leads import Leads
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.paths import Crossings


def world(*vehicles):
    """(x, y, heading in degrees, speed, acceleration) each, cars of 4.6 by 1.8 m, all there for a while."""
    t = Traffic(0.1)
    t.x, t.y, heading, t.speed, t.accel = (np.array(column, float) for column in zip(*vehicles, strict=True))
    t.heading, n = np.radians(heading), len(vehicles)
    t.old_speed, t.length, t.width = t.speed - t.accel * t.dt, np.full(n, 4.6), np.full(n, 1.8)
    t.serial, t.here, t.present = np.arange(1.0, n + 1), np.ones(n, np.bool_), np.arange(n)
    return t


def followers(t, gap, wrecked=(False, False)):
    """The pairs when SUMO names vehicle 1 as the lead of vehicle 0."""
    leads = Leads(t, cycle=t.dt, horizon=5.0)
    leads.lead, leads.gap, leads.egos = np.array([1, -1]), np.array([gap, np.inf]), np.array([0])
    return following(t, leads, np.array(wrecked))


def test_a_lead_straight_ahead():
    pairs = followers(world((0, 0, 0, 20, 0), (24.6, 0, 0, 10, -2)), 20.0)
    assert pairs.slots.tolist() == [[0, 1]]
    assert (pairs.gap[0], pairs.ttc[0], pairs.drac[0], pairs.required[0]) == (20, 2, 2.5, 4.5)
    assert pairs.threat.all()


def test_a_lead_round_a_bend_of_20_m():
    turned = 60
    rear = 20 * np.sin(np.radians(turned)), 20 * (1 - np.cos(np.radians(turned)))
    front = rear[0] + 4.6 * np.cos(np.radians(turned)), rear[1] + 4.6 * np.sin(np.radians(turned))
    t = world((0, 0, 0, 10, 0), (*front, turned - 1, 5, 0))
    assert len(followers(t, 20 * np.radians(turned)).key) == 1


@pytest.mark.parametrize(
    ("lead", "gap", "wrecked"),
    [
        pytest.param((24.6, 3.2, 0, 10, 0), 20, (False, False), id="on the lane beside"),
        pytest.param((24.6, 0, 0, 10, 0), 40, (False, False), id="not where the gap says"),
        pytest.param((20, 4.6, 90, 10, 0), 20, (False, False), id="across"),
        pytest.param((24.6, 0, 0, 25, 0), 20, (False, False), id="going away"),
        pytest.param((24.6, 0, 0, 10, 0), 20, (True, False), id="the ego is a wreck"),
    ],
)
def test_what_is_no_lead_to_close_in_on(lead, gap, wrecked):
    assert len(followers(world((0, 0, 0, 20, 0), lead), gap, wrecked).key) == 0


def crossers(t, *zone):
    """The pairs when the paths of vehicles 0 and 1 cross."""
    both = np.array([zone, (*zone[2:], *zone[:2])], float)
    return crossing(t, Crossings(np.array([0, 1]), np.array([1, 0]), both), np.zeros(2, np.bool_))


def test_two_that_would_be_at_the_crossing_at_the_same_time():
    pairs = crossers(world((-20, 0, 0, 10, 0), (0, -24, 90, 10, -2)), 20, 24, 24, 28)
    assert pairs.slots.tolist() == [[0, 1]]
    assert (pairs.second[0], pairs.ttc[0]) == (1, 2.4)
    # The first has left at 2.86 s.
    assert pairs.drac[0] == pytest.approx(2 * (10 * 2.86 - 24) / 2.86**2)
    assert pairs.ttc2[0] == pytest.approx(np.inf), "braking as it does the second comes later"
    assert pairs.gap[0] == pytest.approx(np.hypot(20 - 0.9, 24 - 0.9))


def test_who_stands_is_on_no_collision_course_and_who_has_gone_is_no_pair():
    t = world((-20, 0, 0, 10, 0), (0, -2, 90, 0, 0))
    assert crossers(t, 20, 24, 2, 6).ttc.tolist() == [np.inf]
    assert len(crossers(t, -10, -5, 2, 6).key) == 0
    assert len(crossers(t, 60, 64, 2, 6).key) == 0


def test_both_at_the_crossing_are_under_threat_without_a_time_to_collision():
    pairs = crossers(world((0, 0, 0, 5, 0), (6, -6, 90, 5, 0)), -1, 6, -1, 6)
    assert pairs.threat.all()
    assert np.isinf(pairs.ttc).all()
    assert not pairs.drac.any()
