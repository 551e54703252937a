import numpy as np
import pytest

from aeb_sumo.swarm import SwarmParams, minimise

LOWER, UPPER = np.array([-2.0, -1.0, 0.0]), np.array([2.0, 3.0, 5.0])


def sphere(x):
    return ((x - [0.5, 1.0, 2.0]) ** 2).sum(axis=1)


def rosenbrock(x):
    return (100 * (x[:, 1:] - x[:, :-1] ** 2) ** 2 + (1 - x[:, :-1]) ** 2).sum(axis=1)


def find(cost, seed=0, lower=LOWER, upper=UPPER, params=None):
    return minimise(cost, lower=lower, upper=upper, rng=np.random.default_rng(seed), params=params)


@pytest.mark.parametrize("seed", range(5))
def test_finds_the_minimum_of_a_sphere(seed):
    best = find(sphere, seed)
    assert best.position == pytest.approx([0.5, 1.0, 2.0], abs=0.03)
    assert best.cost == sphere(best.position[None])[0]


@pytest.mark.parametrize("seed", range(5))
def test_finds_the_end_of_rosenbrocks_valley(seed):
    best = find(rosenbrock, seed, lower=[-2, -2], upper=[2, 2], params=SwarmParams(iterations=300))
    assert best.position == pytest.approx([1.0, 1.0], abs=0.02)


def test_a_minimum_at_the_bounds_is_reached_exactly():
    assert find(lambda x: x.sum(axis=1)).position.tolist() == LOWER.tolist()


def test_evaluates_the_whole_swarm_at_once_and_within_the_bounds():
    seen = []

    def cost(x):
        seen.append(x.copy())
        return -sphere(x)

    find(cost)
    places = np.array(seen)
    assert places.shape == (50, 20, 3)
    assert np.all((places >= LOWER) & (places <= UPPER))
    assert np.all(np.abs(np.diff(places, axis=0)) <= 0.2 * (UPPER - LOWER) + 1e-12)


def test_history_never_rises_and_ends_at_the_cost():
    best = find(rosenbrock)
    assert len(best.history) == 50
    assert np.all(np.diff(best.history) <= 0)
    assert best.history[-1] == best.cost


def test_same_seed_same_result():
    one, same, other = find(rosenbrock, 1), find(rosenbrock, 1), find(rosenbrock, 2)
    assert one.position.tolist() == same.position.tolist()
    assert one.history.tolist() == same.history.tolist()
    assert one.position.tolist() != other.position.tolist()


def test_a_place_without_a_cost_is_never_the_best():
    best = find(lambda x: np.where(x[:, 0] < 1, np.nan, sphere(x)))
    assert best.position[0] == pytest.approx(1.0, abs=0.03)
    assert best.position[0] >= 1


def test_errors():
    with pytest.raises(ValueError, match="lower <= upper"):
        find(sphere, lower=UPPER, upper=LOWER)
    with pytest.raises(ValueError, match="lower <= upper"):
        find(sphere, lower=[0.0], upper=UPPER)
    with pytest.raises(ValueError, match="finite"):
        find(lambda x: np.full(len(x), np.nan))
