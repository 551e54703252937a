from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aeb_sumo import strategies
from aeb_sumo.criticality import time_to_contact
from aeb_sumo.strategies.base import Phase
from aeb_sumo.units import G
from tests.helpers import percept

MU = 0.85
DT = 0.05


def speeds_and_accels():
    return st.tuples(st.floats(0, 40), st.floats(-9, 3))


@given(st.floats(0.5, 100), speeds_and_accels(), speeds_and_accels())
def test_time_to_contact_is_that_of_a_simulation(gap, ego, lead):
    time = np.arange(0, 40, 0.01)

    def driven(speed, accel):
        until = np.minimum(time, speed / -accel) if accel < 0 else time
        return speed * until + accel * until**2 / 2

    left = gap + driven(*lead) - driven(*ego)
    touched = time[left <= 0]
    found = float(time_to_contact(gap=gap, speed=ego[0], accel=ego[1], lead_speed=lead[0], lead_accel=lead[1]))
    if len(touched):
        assert found == pytest.approx(touched[0], abs=0.011)
    elif np.isfinite(found):
        assert found >= time[-1] or left.min() < 1e-2, "a mere touch, between two instants"


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"gap": 0.0, "speed": 10, "accel": 0, "lead_speed": 0, "lead_accel": 0}, 0.0),
        ({"gap": 30, "speed": 10, "accel": 0, "lead_speed": 0, "lead_accel": 0}, 3.0),
        ({"gap": 30, "speed": 10, "accel": 0, "lead_speed": 10, "lead_accel": 0}, np.inf),
        ({"gap": 30, "speed": 10, "accel": -2, "lead_speed": 0, "lead_accel": 0}, np.inf),  # stands after 25 m
        ({"gap": 30, "speed": 20, "accel": 0, "lead_speed": 10, "lead_accel": -10}, 1.75),  # lead stands after 1 s
        ({"gap": np.inf, "speed": 20, "accel": 0, "lead_speed": 0, "lead_accel": 0}, np.inf),
    ],
)
def test_time_to_contact_by_hand(values, expected):
    assert time_to_contact(**values) == pytest.approx(expected)


def behind(system, *, gap, speed, lead_speed, lead_decel, hidden_until):
    """(n,) smallest gap behind leads that brake to a stop and are seen from an instant on, and (n,) first braking."""
    n = len(gap)
    state, accel, smallest, first = system.init(n), np.zeros(n), gap.copy(), np.full(n, np.inf)
    for k in range(400):
        decel = np.where(lead_speed > 0, lead_decel, 0.0)
        seen = percept(
            valid=k * DT >= hidden_until, gap=gap, ego_speed=speed, ego_accel=accel, target_speed=lead_speed,
            target_accel=-decel, mu=MU,
        )  # fmt: skip
        state, demand = system.step(state, seen, DT)
        first = np.where((demand.decel > 0) & np.isinf(first), k * DT, first)
        decel_now = np.minimum(demand.decel, MU * G)
        slower, lead_slower = np.maximum(speed - decel_now * DT, 0), np.maximum(lead_speed - decel * DT, 0)
        gap = gap + ((lead_speed + lead_slower) - (speed + slower)) / 2 * DT
        accel, speed, lead_speed = (slower - speed) / DT, slower, lead_slower
        smallest = np.minimum(smallest, gap)
    return smallest, first


@pytest.fixture(scope="module")
def leads():
    rng = np.random.default_rng(1)
    n = 500
    return {
        "gap": rng.uniform(1, 60, n), "speed": rng.uniform(5, 35, n), "lead_speed": rng.uniform(0, 30, n),
        "lead_decel": rng.uniform(0, MU * G, n),
    }  # fmt: skip


def test_braking_later_never_avoids_more(leads):
    system = strategies.load("perfect")
    _, first = behind(system, **leads, hidden_until=0.0)
    gaps = [behind(system, **leads, hidden_until=first + late)[0] for late in (0.0, 0.1, 0.3, 1.0)]
    for sooner, later in pairwise(gaps):
        # To within a step: it releases as soon as nothing closes in.
        assert np.all(sooner >= later - 0.1)
        assert np.count_nonzero(sooner > 0) >= np.count_nonzero(later > 0)
    avoided = [np.count_nonzero(gap > 0) for gap in gaps]
    assert avoided[0] > avoided[-1] + 20, "the test has cases in which it matters"


@pytest.mark.parametrize("name", [n for n in strategies.names() if n != "none"])
def test_no_strategy_avoids_what_perfect_does_not(leads, name):
    """With a perfect sensor for all, and a brake that does what they demand."""
    perfect, _ = behind(strategies.load("perfect"), **leads, hidden_until=0.0)
    other, _ = behind(strategies.load(name), **leads, hidden_until=0.0)
    assert not np.any((other > 0.01) & (perfect <= 0))


def test_who_would_be_hit_at_a_crossing_is_not_saved_by_any_braking_but_the_fullest():
    """Whoever of them is hit with full braking at once is hit with every other, too."""
    rng = np.random.default_rng(2)
    saved = harmed = 0
    for _ in range(300):
        speed, to, through = rng.uniform(3, 20), rng.uniform(1, 40), rng.uniform(5, 10)
        comes = rng.uniform(0, 5)
        goes = comes + rng.uniform(0.3, 2)

        def hit(decels, speed=speed, to=to, through=through, comes=comes, goes=goes):
            v = np.maximum(speed - np.cumsum(decels) * DT, 0)
            x = np.cumsum(v) * DT
            inside = (x > to) & (x < to + through)
            time = np.arange(len(x)) * DT
            return bool((inside & (time >= comes) & (time <= goes)).any())

        steps = 200
        if not hit(np.zeros(steps)):
            harmed += hit(np.full(steps, MU * G))
            continue
        if hit(np.full(steps, MU * G)):
            for _ in range(20):
                profile = rng.uniform(0, MU * G, steps) * (rng.random(steps) < rng.random())
                assert hit(profile)
        else:
            saved += 1
    assert saved > 20
    assert harmed > 0, "who would not be hit must not brake"


def test_perfect_follows_the_speed_of_a_braking_lead_and_no_lower():
    system = strategies.load("perfect")
    state = system.init(1)
    _, demand = system.step(state, percept(gap=10, ego_speed=10, target_speed=10, target_accel=-4.0), 0.1)
    assert demand.decel[0] == pytest.approx(4.0)
    assert demand.phase[0] == Phase.PARTIAL_BRAKE
    _, demand = system.step(state, percept(gap=10, ego_speed=15, target_speed=10, target_accel=-4.0), 0.1)
    assert demand.decel[0] == pytest.approx(MU * G)
    assert demand.phase[0] == Phase.FULL_BRAKE


def test_perfect_leaves_alone_who_brakes_himself():
    system = strategies.load("perfect")
    for own, brakes in ((-4.0, False), (0.0, True)):
        _, demand = system.step(system.init(1), percept(gap=30, ego_speed=15, ego_accel=own), 0.1)
        assert (demand.decel[0] > 0) == brakes


def test_where_the_horizon_is_too_short_to_stop_in_perfect_brakes_sooner():
    system = strategies.load("perfect")
    for mu, brakes in ((0.85, False), (0.2, True)):  # 5 s to a standing lead; from 20 m/s it takes 2 m/s2
        _, demand = system.step(system.init(1), percept(gap=100, ego_speed=20, mu=mu), 0.1)
        assert (demand.decel[0] > 0) == brakes


def test_the_careful_driver_brakes_after_his_reaction_time_and_forgets_what_is_over():
    system, state, onset = strategies.load("careful"), strategies.load("careful").init(2), []
    for k in range(20):
        over = k >= 5
        gap = np.array([28.0, 1000.0 if over else 28.0])  # a TTC of 1.9 s; the second one's lead drives off
        state, demand = system.step(
            state, percept(gap=gap, ego_speed=15.0, target_speed=np.array([0.0, 20.0 if over else 0.0])), DT
        )
        onset.append(demand.decel > 0)
    first = np.argmax(np.array(onset), axis=0)
    assert first[0] * DT == pytest.approx(0.75)
    assert not np.array(onset)[:, 1].any()
    assert demand.decel[0] == pytest.approx(0.774 * G)


def test_the_careful_driver_sees_brake_lights():
    system = strategies.load("careful")
    for decel, sees in ((4.9, False), (5.0, True)):
        state, _ = system.step(system.init(1), percept(gap=50, ego_speed=20, target_speed=20, target_accel=-decel), DT)
        assert np.isfinite(state.due[0]) == sees
