"""The brake that the platform owns: dead time, build-up, lag, friction limit, and the PID loop around them.

SUMO only executes the speed that comes out of here, one per step; its own limits on braking are off meanwhile.
"""

from dataclasses import dataclass

import numpy as np

from aeb_sumo.soa import Floats
from aeb_sumo.units import G
from aeb_sumo.vehicle.lower_controller import PidParams, PidState, pid_init, pid_step

__all__ = ["BrakeParams", "BrakeState", "brake_init", "brake_step"]


@dataclass(frozen=True, kw_only=True)
class BrakeParams:
    """An actuator and its controller.

    Attributes:
        dead_time: from the controller's output to the first change of pressure [s], our assumption.
        lag: time constant of the first-order response behind it [s]; 0.05 fits the results of Zhao et al. 2025
            (shared/seeds.md 8), from another source.
        build_up: largest rise of deceleration per second [m/s3], our assumption; `inf` for no limit.
        release: largest fall of deceleration per second [m/s3], our assumption.
        hold: once the system has brought the car to a stop, the brake stays on for this long [s], our assumption.
        pid: the lower controller; None takes the gains that suit this actuator (`PidParams.for_plant`).
        substep: largest step of the integration [s], our assumption.
    """

    dead_time: float = 0.1
    lag: float = 0.05
    build_up: float = 40.0
    release: float = 40.0
    hold: float = 2.0
    pid: PidParams | None = None
    substep: float = 0.01

    @property
    def controller(self) -> PidParams:
        """The gains in use."""
        return self.pid or PidParams.for_plant(lag=self.lag, dead_time=self.dead_time)

    def substeps(self, dt: float) -> int:
        """Substeps of a step of `dt` [s]."""
        return max(1, round(dt / self.substep))


@dataclass(frozen=True)
class BrakeState:
    """Memory of the brake, one row per vehicle.

    Attributes:
        decel: (n,) what the brake does now, >= 0 [m/s2].
        pipe: (n, k) outputs of the controller still within the dead time, oldest first [m/s2].
        integral, error: (n,) memory of the PID controller.
    """

    decel: Floats
    pipe: Floats
    integral: Floats
    error: Floats


def brake_init(params: BrakeParams, n: int, dt: float) -> BrakeState:
    """State of `n` released brakes, for steps of `dt` [s]."""
    pid = pid_init(n)
    delay = round(params.dead_time / (dt / params.substeps(dt)))
    return BrakeState(np.zeros(n), np.zeros((n, delay)), pid.integral, pid.error)


def brake_step(
    params: BrakeParams, state: BrakeState, *, demand: Floats, mu: Floats, dt: float
) -> tuple[BrakeState, Floats]:
    """Follow `demand` for one step of the simulation.

    Args:
        params: actuator and controller.
        state: (n,) memory.
        demand: (n,) demanded deceleration, >= 0 [m/s2], constant over the step.
        mu: (n,) friction coefficient of the road; the deceleration never exceeds `mu g`.
        dt: step [s], that of `brake_init`.

    Returns:
        The new state and the (n,) mean deceleration over the step [m/s2]: `dt` times it is the loss of speed.
    """
    substeps = params.substeps(dt)
    h = dt / substeps
    limit = mu * G
    demand = np.minimum(demand, limit)
    gains, pid = params.controller, PidState(state.integral, state.error)
    decel, pipe = state.decel, state.pipe
    # Exact for a constant input over the substep, so the lag may be as short as the substep.
    follow = 1.0 if params.lag == 0 else 1 - np.exp(-h / params.lag)
    lost = np.zeros_like(decel)
    for _ in range(substeps):
        pid, controlled = pid_step(gains, pid, demand=demand, actual=decel, dt=h)
        if pipe.shape[1]:
            arriving = pipe[:, 0]
            pipe = np.column_stack([pipe[:, 1:], controlled])
        else:
            arriving = controlled
        change = np.clip((arriving - decel) * follow, -params.release * h, params.build_up * h)
        new = np.clip(decel + change, 0.0, limit)
        lost += (decel + new) / 2 * h
        decel = new
    return BrakeState(decel, pipe, pid.integral, pid.error), lost / dt
