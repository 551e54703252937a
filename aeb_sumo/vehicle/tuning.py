"""The PID gains of Zhao et al. 2025, 2.2, which it tunes by particle swarm and does not print."""

from dataclasses import replace
from functools import cache, partial

import numpy as np

from aeb_sumo.soa import Floats
from aeb_sumo.swarm import minimise
from aeb_sumo.vehicle.brake import BrakeParams, brake_init, brake_step
from aeb_sumo.vehicle.lower_controller import PidParams

__all__ = ["LOWER", "STEPS", "UPPER", "itae", "step_response", "tuned"]

STEPS = (2.0, 4.0, 6.0, 8.0)
"""Demands in the tuning manoeuvres, from 0 at t = 0 [m/s2], our assumption. Several: where the build-up is limited,
gains tuned on one height overshoot at another."""

DURATION = 2.0
"""Length of the tuning manoeuvre [s], our assumption."""

LOWER, UPPER = (0.05, 0.05, 0.0), (1.0, 0.5, 0.1)
"""Bounds of kp, ti [s] and td [s], our assumption: calibrated. They decide where the brake has no dead time (`tuned`);
there they leave the loop the lag of 0.05 s that the published results of Zhao et al. ask for (shared/seeds.md 8)."""


def step_response(brake: BrakeParams, gains: Floats) -> Floats:
    """Deceleration of the brake after each of the steps of the demand, on a road that always grips.

    Args:
        brake: the actuator; its own controller is not used.
        gains: (n, 3) kp, ti [s], td [s]; each row is a brake of its own.

    Returns:
        (n, m, k) deceleration at the end of each substep of `DURATION` for each of `STEPS` [m/s2].
    """
    # One gain per row.
    each = np.repeat(gains, len(STEPS), axis=0)
    brake = replace(brake, pid=PidParams(kp=each[:, 0], ti=each[:, 1], td=each[:, 2]))  # type: ignore[arg-type]
    n, dt = len(each), brake.substep
    demand, mu = np.tile(STEPS, len(gains)), np.full(n, np.inf)
    state = brake_init(brake, n, dt)
    response = np.empty((n, round(DURATION / dt)))
    for k in range(response.shape[1]):
        state, _ = brake_step(brake, state, demand=demand, mu=mu, dt=dt)
        response[:, k] = state.decel
    return response.reshape(len(gains), len(STEPS), -1)


def itae(brake: BrakeParams, gains: Floats) -> Floats:
    """`integral t |e| dt` of the step responses by the height of the step, mean of `STEPS`, (n,) [s2].

    The swarm's cost (2.2); lower is better.
    """
    response = step_response(brake, gains)
    time = brake.substep * np.arange(1, response.shape[-1] + 1)
    error = np.abs(1 - response / np.array(STEPS)[:, None])
    cost: Floats = (error @ time).mean(axis=1) * brake.substep
    return cost


@cache
def tuned(
    *, lag: float, dead_time: float, build_up: float = np.inf, release: float = np.inf, seed: int = 0
) -> PidParams:
    """Gains with the least ITAE for a brake, found by the printed swarm (0.2 s the first time, then remembered).

    What the loop does, against the SIMC gains of `PidParams.for_plant` (measured, seed 0, lag 0.05 s; time until 63 %,
    overshoot: the largest of the steps):

    =========================  =====  =====  =====  ===============  ============  =========
    brake                      kp     ti     td     ITAE (SIMC)      63 % [s]      overshoot
    =========================  =====  =====  =====  ===============  ============  =========
    no dead time               1.00   0.050  0      0.0022 (0.0022)  0.05          0
    dead time 0.02 s, 80 m/s3  0.95   0.050  0      0.0026 (0.0033)  0.06 to 0.09  13 %
    dead time 0.1 s            0.59   0.082  0.026  0.0118 (0.0273)  0.15 to 0.17  7 %
    =========================  =====  =====  =====  ===============  ============  =========

    Nothing stops a loop around a pure lag from being ever faster, and the source prints no bounds: without dead time
    the gains are those of the bounds.

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
