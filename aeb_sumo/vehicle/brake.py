"""The brake that the platform owns: dead time, build-up, lag, friction limit, and the PID loop around them.

SUMO only executes the speed that comes out of here, one per step; its own limits on braking are off meanwhile.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from aeb_sumo.errors import InputError
from aeb_sumo.parameters import check, within
from aeb_sumo.soa import Floats
from aeb_sumo.units import G
from aeb_sumo.vehicle.lower_controller import PidParams, PidState, pid_init, pid_step

__all__ = ["BrakeParams", "BrakeState", "brake_init", "brake_step"]


@dataclass(frozen=True, kw_only=True)
class BrakeParams:
    """An actuator and its controller.

    Attributes:
        dead_time: from the controller's output to the first change of pressure [s], our assumption. Without a lower
            controller only a rise waits: nobody brakes on for the long dead times that are fitted to some results.
        dead_time_by_mu: (mu, dead time [s]) pairs, mu rising, linear between them and constant beyond, in place of
            `dead_time`, our assumption: none; for systems whose published results ask for one that depends on the road.
        lag: time constant of the first-order response behind it [s]; 0.05 fits the results of Zhao et al. 2025
            (shared/seeds.md 8), from another source.
        build_up: largest rise of deceleration per second [m/s3], our assumption; `inf` for no limit.
        release: largest fall of deceleration per second [m/s3], our assumption.
        hold: once the system has brought the car to a stop, the brake stays on for this long [s], our assumption.
        pid: the lower controller; None takes the gains that suit this actuator (`PidParams.for_plant`).
        open_loop: there is no lower controller; the actuator gets the demand.
        substep: largest step of the integration [s], our assumption.
    """

    dead_time: float = within(0.1, 0.0, 5.0)
    dead_time_by_mu: tuple[tuple[float, float], ...] = ()
    lag: float = 0.05
    build_up: float = within(40.0, 1.0, np.inf)
    release: float = within(40.0, 1.0, np.inf)
    hold: float = 2.0
    pid: PidParams | None = None
    open_loop: bool = False
    substep: float = within(0.01, 0.0001, 0.1)

    def __post_init__(self) -> None:
        """Raises `InputError` for a parameter out of range."""
        check(self)
        mus, times = zip(*self.dead_time_by_mu, strict=True) if self.dead_time_by_mu else ((), ())
        if any(b <= a for a, b in pairwise(mus)) or any(not 0 <= time < np.inf for time in times):
            raise InputError("BrakeParams.dead_time_by_mu must have rising mu and times >= 0 s")

    @property
    def controller(self) -> PidParams:
        """The gains in use."""
        return self.pid or PidParams.for_plant(lag=self.lag, dead_time=self.dead_time)

    def dead_times(self, mu: Floats) -> Floats:
        """(n,) dead time on roads of friction `mu` [s]."""
        if not self.dead_time_by_mu:
            return np.full(len(mu), self.dead_time)
        result: Floats = np.interp(mu, *np.array(self.dead_time_by_mu).T)
        return result

    def longest_dead_time(self) -> float:
        """The longest dead time on any road [s]."""
        return max((time for _, time in self.dead_time_by_mu), default=self.dead_time)

    def substeps(self, dt: float) -> int:
        """Substeps of a step of `dt` [s]."""
        return max(1, round(dt / self.substep))


@dataclass(frozen=True)
class BrakeState:
    """Memory of the brake, one row per vehicle.

    Attributes:
        decel: (n,) what the brake does now, >= 0 [m/s2].
        pipe: (n, k) outputs of the controller on their way through the dead time, next to arrive first [m/s2].
        integral, error: (n,) memory of the PID controller.
    """

    decel: Floats
    pipe: Floats
    integral: Floats
    error: Floats


def brake_init(params: BrakeParams, n: int, dt: float) -> BrakeState:
    """State of `n` released brakes, for steps of `dt` [s]."""
    pid = pid_init(n)
    delay = round(params.longest_dead_time() / (dt / params.substeps(dt)))
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
    length = pipe.shape[1]
    # What enters the pipe now arrives after the dead time of this road; until something else enters, it lasts.
    delay = np.rint(params.dead_times(mu) / h)
    at_once, behind = delay == 0, np.arange(length) >= delay[:, None] - 1
    for _ in range(substeps):
        controlled = demand
        if not params.open_loop:
            pid, controlled = pid_step(gains, pid, demand=demand, actual=decel, dt=h)
        if length:
            arriving = np.minimum(pipe[:, 0], controlled) if params.open_loop else pipe[:, 0]
            arriving = np.where(at_once, controlled, arriving)
            pipe = np.where(behind, controlled[:, None], np.column_stack([pipe[:, 1:], controlled]))
        else:
            arriving = controlled
        change = np.clip((arriving - decel) * follow, -params.release * h, params.build_up * h)
        new = np.clip(decel + change, 0.0, limit)
        lost += (decel + new) / 2 * h
        decel = new
    return BrakeState(decel, pipe, pid.integral, pid.error), lost / dt
