"""The PID gains of Zhao et al. 2025, 2.2, which it tunes by particle swarm and does not print."""

from dataclasses import replace
from functools import cache, partial

import numpy as np

from aeb_sumo.soa import Floats
from aeb_sumo.swarm import minimise
from aeb_sumo.vehicle.brake import BrakeParams, brake_init, brake_step
from aeb_sumo.vehicle.lower_controller import PidParams

__all__ = ["itae", "step_response", "tuned"]

STEP = 6.0
"""Demand in the tuning manoeuvre, from 0 at t = 0 [m/s2], our assumption: about the strongest published braking."""

DURATION = 2.0
"""Length of the tuning manoeuvre [s], our assumption."""

LOWER, UPPER = (0.05, 0.01, 0.0), (2.0, 0.5, 0.1)
"""Bounds of kp, ti [s] and td [s], our assumption. They decide where the brake has no dead time: see `tuned`."""


def step_response(brake: BrakeParams, gains: Floats) -> Floats:
    """Deceleration of the brake after a step of the demand to `STEP`, on a road that always grips.

    Args:
        brake: the actuator; its own controller is not used.
        gains: (n, 3) kp, ti [s], td [s]; each row is a brake of its own.

    Returns:
        (n, k) deceleration at the end of each substep of `DURATION` [m/s2].
    """
    # One gain per row: `pid_step` broadcasts.
    brake = replace(brake, pid=PidParams(kp=gains[:, 0], ti=gains[:, 1], td=gains[:, 2]))  # type: ignore[arg-type]
    n, dt = len(gains), brake.substep
    demand, mu = np.full(n, STEP), np.full(n, np.inf)
    state = brake_init(brake, n, dt)
    response = np.empty((n, round(DURATION / dt)))
    for k in range(response.shape[1]):
        state, _ = brake_step(brake, state, demand=demand, mu=mu, dt=dt)
        response[:, k] = state.decel
    return response


def itae(brake: BrakeParams, gains: Floats) -> Floats:
    """`integral t |e| dt` of the step response, (n,) [m], the swarm's cost (2.2); lower is better."""
    response = step_response(brake, gains)
    time = brake.substep * np.arange(1, response.shape[1] + 1)
    cost: Floats = np.abs(STEP - response) @ time * brake.substep
    return cost


@cache
def tuned(
    *, lag: float, dead_time: float, build_up: float = np.inf, release: float = np.inf, seed: int = 0
) -> PidParams:
    """Gains with the least ITAE for a brake, found by the printed swarm (0.2 s the first time, then remembered).

    What the loop does, against the SIMC gains of `PidParams.for_plant` (measured, seed 0, lag 0.05 s; time until 63 %):

    ==================================  =====  =====  =====  ==============  =========  ==========
    brake                               kp     ti     td     ITAE (SIMC)     63 % [s]   overshoot
    ==================================  =====  =====  =====  ==============  =========  ==========
    dead time 0.02 s, 80 m/s3           1.48   0.079  0.007  0.012 (0.017)   0.07       1 %
    dead time 0.1 s                     0.56   0.080  0.024  0.069 (0.164)   0.16       3 %
    no dead time                        2.00   0.010  0      0.002 (0.013)   0.02       5 %
    ==================================  =====  =====  =====  ==============  =========  ==========

    Nothing stops a loop around a pure lag from being ever faster: without dead time the gains are those of the bounds,
    so give the brake what it has in life, a dead time and a limited build-up.

    Args:
        lag: time constant of the brake [s].
        dead_time: of the brake [s].
        build_up: largest rise of deceleration per second [m/s3]; our assumption: no limit.
        release: largest fall of deceleration per second [m/s3]; our assumption: no limit.
        seed: of the swarm, our assumption.
    """
    brake = BrakeParams(lag=lag, dead_time=dead_time, build_up=build_up, release=release)
    best = minimise(partial(itae, brake), lower=LOWER, upper=UPPER, rng=np.random.default_rng(seed))
    kp, ti, td = best.position.tolist()
    return PidParams(kp=kp, ti=ti, td=td)
