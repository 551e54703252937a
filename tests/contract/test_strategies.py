"""Laws that every registered strategy keeps."""

from dataclasses import fields

import numpy as np
import pytest

from aeb_sumo import strategies
from aeb_sumo.soa import take
from aeb_sumo.strategies.base import Phase
from tests.helpers import percept

NAMES = strategies.names()
DT = 0.1

# The largest rise of a demand when the gap grows by 0.1 m [m/s2]. zhao2025: its upper controller takes the centroid
# (2.1, "centre of gravity") of output sets clipped at the firing strength; between the narrow input sets all strengths
# are small, the clipped sets are flat and their centroid leans to the middle of the universe, so the surface ripples.
# zheng2020: the same ("centre of gravity" of Gaussian sets); measured 0.041 here, 0.36 anywhere (at 5.4 km/h, 0.2 m).
RIPPLE = {"zhao2025": 0.5, "zheng2020": 0.05}


# Systems whose parameters choose between rules: the laws hold for each.
VARIANTS = {
    "yan2025 lane_entry": ("yan2025", {"rule": "lane_entry"}),
    "lin2021 prior": ("lin2021", {"knows_road": False}),
    **{f"zheng2020 class {k}": ("zheng2020", {"driver_class": k}) for k in (2, 3, 4)},
}


@pytest.fixture(params=[*NAMES, *VARIANTS])
def system(request):
    return strategies.load(*VARIANTS.get(request.param, (request.param,)))


def random_percepts(n=400, seed=0, **values):
    """Leads ahead; `values` overrule what is drawn."""
    rng = np.random.default_rng(seed)
    drawn = {
        "valid": rng.random(n) < 0.9,
        "gap": rng.uniform(0.1, 80, n),
        "ego_speed": rng.uniform(0, 35, n),
        "ego_accel": rng.normal(0, 2, n),
        "target_speed": np.where(rng.random(n) < 0.3, 0.0, rng.uniform(0, 30, n)),
        "target_accel": rng.normal(-1, 2, n),
        "left": rng.uniform(-3, 3, n),
        "closing_left": rng.normal(0, 2, n),
        "vulnerable": rng.random(n) < 0.3,
        "mu": rng.uniform(0.2, 1.0, n),
    }
    return percept(**drawn | values)


def drive(system, percepts):
    """Two different situations after one another, so that the memory is not fresh."""
    state = system.init(len(percepts[0].gap))
    for each in percepts:
        state, demand = system.step(state, each, DT)
    return state, demand


def same(a, b):
    return all(np.array_equal(getattr(a, f.name), getattr(b, f.name), equal_nan=True) for f in fields(a))


def test_nothing_farther_away_than_the_longest_ttc_makes_it_act(system):
    """So that what is farther away need not be watched (`aeb_sumo.world.leads`)."""
    rng = np.random.default_rng(7)
    for mu in (0.2, 0.5, 0.85):
        closing = rng.uniform(0.1, 40, 400)
        gap = closing * system.longest_ttc(mu) * rng.uniform(1.001, 3, 400)
        _, demand = system.step(system.init(400), percept(gap=gap, ego_speed=closing, mu=mu), DT)
        assert (demand.phase == Phase.NONE).all()


def test_there_are_strategies():
    assert {"none", "zhao2025"} <= set(NAMES)


def test_batch_equals_singles_and_order_does_not_matter(system):
    percepts = [random_percepts(seed=1), random_percepts(seed=2)]
    _, batch = drive(system, percepts)
    for k in range(0, 400, 7):
        _, one = drive(system, [take(p, np.array([k])) for p in percepts])
        assert same(one, take(batch, np.array([k])))
    order = np.random.default_rng(3).permutation(400)
    _, shuffled = drive(system, [take(p, order) for p in percepts])
    assert same(shuffled, take(batch, order))


def test_inputs_are_not_changed(system):
    seen, state = random_percepts(), system.init(400)
    copies = take(seen, np.arange(400)), take(state, np.arange(400))
    system.step(state, seen, DT)
    assert same(seen, copies[0])
    assert same(state, copies[1])


def test_no_valid_target_no_braking(system):
    _, demand = drive(system, [random_percepts(valid=True), random_percepts(valid=False)])
    assert np.all(demand.phase == Phase.NONE)
    assert np.all(demand.decel == 0)


@pytest.mark.parametrize("change", [{"ego_speed": 0.0}, {"target_speed": 40.0}], ids=["ego stands", "gap opens"])
def test_no_demand_when_the_ego_stands_or_the_gap_opens(system, change):
    _, demand = drive(system, [random_percepts(seed=5), random_percepts(**change)])
    assert np.all(demand.phase == Phase.NONE)
    assert np.all(demand.decel == 0)


def test_demands_are_well_formed(system):
    _, demand = drive(system, [random_percepts(seed=1), random_percepts(seed=2)])
    assert np.all(np.isfinite(demand.decel) & (demand.decel >= 0))
    assert np.all((demand.decel == 0) | (demand.phase >= Phase.PARTIAL_BRAKE))
    assert set(np.unique(demand.phase)) <= {int(p) for p in Phase}


def test_a_smaller_gap_never_lowers_the_demand(system):
    gaps = np.arange(0.1, 60, 0.1)
    for speed, target in ((8.0, 0.0), (14.0, 0.0), (20.0, 5.6), (30.0, 20.0)):
        _, demand = system.step(system.init(len(gaps)), percept(gap=gaps, ego_speed=speed, target_speed=target), DT)
        assert np.all(np.diff(demand.phase) <= 0)
        assert np.max(np.diff(demand.decel)) <= RIPPLE.get(system.name, 0.0)


def first_braking(system, dt):
    """Instant at which braking for a standing lead begins."""
    gap, speed, state, time = 60.0, 15.0, system.init(1), 0.0
    while gap > 0:
        state, demand = system.step(state, percept(gap=gap, ego_speed=speed), dt)
        if demand.phase[0] >= Phase.PARTIAL_BRAKE:
            return time
        gap, time = gap - speed * dt, time + dt
    return None


def test_halving_the_step_moves_the_trigger_by_at_most_a_step(system):
    coarse, fine = first_braking(system, 0.1), first_braking(system, 0.05)
    assert (coarse is None) == (fine is None) == (system.name == "none")
    if coarse is not None:
        assert abs(coarse - fine) <= 0.1 + 1e-9


def test_none_never_brakes():
    system = strategies.load("none")
    _, demand = drive(system, [random_percepts()])
    assert not demand.phase.any()


def test_a_source_is_named(system):
    assert system.source
