"""Particle swarm optimisation as Zhao et al. 2025, 2.2, use it: the whole swarm is one array."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from aeb_sumo.soa import Floats

__all__ = ["Optimum", "SwarmParams", "minimise"]


@dataclass(frozen=True, kw_only=True)
class SwarmParams:
    """A swarm.

    Attributes:
        particles: size of the swarm, printed (2.2).
        iterations: evaluations of the whole swarm, printed (2.2).
        inertia_first, inertia_last: weight of a particle's velocity, falling linearly, printed (2.2).
        cognitive: pull c1 towards the best place of the particle itself, our assumption.
        social: pull c2 towards the best place of the swarm, our assumption.
        reach: largest velocity per iteration, as a share of the distance between the bounds, our assumption; with
            these pulls and an inertia of 0.9 a swarm without it only hits the bounds.
    """

    particles: int = 20
    iterations: int = 50
    inertia_first: float = 0.9
    inertia_last: float = 0.4
    cognitive: float = 2.0
    social: float = 2.0
    reach: float = 0.2


@dataclass(frozen=True)
class Optimum:
    """What a swarm has found.

    Attributes:
        position: (d,) the best place.
        cost: the cost there.
        history: (iterations,) the lowest cost so far, after each iteration; it never rises.
    """

    position: Floats
    cost: float
    history: Floats


def minimise(
    cost: Callable[[Floats], Floats],
    *,
    lower: ArrayLike,
    upper: ArrayLike,
    rng: np.random.Generator,
    params: SwarmParams | None = None,
) -> Optimum:
    """The lowest cost within bounds.

    Particles start at rest, uniformly distributed; one that would leave the bounds stops at them (our assumption).

    Args:
        cost: from (particles, d) places to (particles,) costs; a cost of nan or inf is never the best.
        lower: (d,) lower bounds.
        upper: (d,) upper bounds, none below its lower one.
        rng: source of all randomness; the same state gives the same result.
        params: the swarm; None for the printed one.

    Raises:
        ValueError: if the bounds are not two vectors of the same length in order, or no place has a finite cost.
    """
    params = params or SwarmParams()
    low, high = np.asarray(lower, float), np.asarray(upper, float)
    if low.ndim != 1 or low.shape != high.shape or not np.all(low <= high):
        raise ValueError(f"bounds must be two vectors with lower <= upper, not {low} and {high}")
    shape = (params.particles, len(low))
    reach = params.reach * (high - low)

    position, velocity = rng.uniform(low, high, shape), np.zeros(shape)
    own, own_cost = position, np.full(params.particles, np.inf)
    history = np.empty(params.iterations)
    for i, inertia in enumerate(np.linspace(params.inertia_first, params.inertia_last, params.iterations)):
        costs = cost(position)
        better = costs < own_cost
        own, own_cost = np.where(better[:, None], position, own), np.where(better, costs, own_cost)
        leader = int(own_cost.argmin())
        history[i] = own_cost[leader]
        to_own = params.cognitive * rng.random(shape) * (own - position)
        to_leader = params.social * rng.random(shape) * (own[leader] - position)
        velocity = np.clip(inertia * velocity + to_own + to_leader, -reach, reach)
        position = np.clip(position + velocity, low, high)
    if not np.isfinite(own_cost[leader]):
        raise ValueError("no place has a finite cost")
    return Optimum(own[leader], float(own_cost[leader]), history)
