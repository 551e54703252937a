"""The brake that the platform owns: dead time, build-up, lag, friction limit, and the PID loop around them.

SUMO only executes the speed that comes out of here, one per step; its own limits on braking are off meanwhile.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from aeb_sumo.compiled import kernel
from aeb_sumo.errors import InputError
from aeb_sumo.parameters import check, within
from aeb_sumo.soa import Floats, Ints
from aeb_sumo.units import G
from aeb_sumo.vehicle.lower_controller import PidParams

__all__ = ["BrakeParams", "BrakeState", "brake_in_place", "brake_init", "brake_step", "pid_step"]


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
        integral, error: (n,) memory of the controller: integral of its error [m/s], and the last error [m/s2].
    """

    decel: Floats
    pipe: Floats
    integral: Floats
    error: Floats


def brake_init(params: BrakeParams, n: int, dt: float) -> BrakeState:
    """State of `n` released brakes, for steps of `dt` [s]."""
    delay = round(params.longest_dead_time() / (dt / params.substeps(dt)))
    return BrakeState(np.zeros(n), np.zeros((n, delay)), np.zeros(n), np.zeros(n))


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
    new = BrakeState(state.decel.copy(), state.pipe.copy(), state.integral.copy(), state.error.copy())
    return new, brake_in_place(params, new, np.arange(len(demand)), demand=demand, mu=mu, dt=dt)


def brake_in_place(
    params: BrakeParams, state: BrakeState, rows: Ints, *, demand: Floats, mu: Floats, dt: float
) -> Floats:
    """`brake_step` of some rows of `state`, which is changed; `demand`, `mu` and the result are of these rows."""
    substeps = params.substeps(dt)
    h = dt / substeps
    gains = params.controller
    # Exact for a constant input over the substep, so the lag may be as short as the substep.
    follow = 1.0 if params.lag == 0 else float(1 - np.exp(-h / params.lag))
    return _brake(
        rows, demand, mu * G, np.rint(params.dead_times(mu) / h), state.decel, state.pipe, state.integral, state.error,
        np.atleast_1d(gains.kp), np.atleast_1d(gains.ti), np.atleast_1d(gains.td), gains.limit,
        params.open_loop, follow, -params.release * h, params.build_up * h, substeps, h, dt,
    )  # fmt: skip


@kernel
def _brake(
    rows: Ints, demand: Floats, limit: Floats, delay: Floats, decel: Floats, pipe: Floats, integral: Floats,
    error: Floats, kp: Floats, ti: Floats, td: Floats, most: float,
    open_loop: bool, follow: float, fall: float, rise: float, substeps: int, h: float, dt: float,
) -> Floats:  # fmt: skip
    result = np.empty(len(rows))
    length = pipe.shape[1]
    for k in range(len(rows)):
        r, own = rows[k], min(k, len(kp) - 1)
        wanted, now, lost = min(demand[k], limit[k]), decel[r], 0.0
        for _ in range(substeps):
            arriving = wanted
            if not open_loop:
                off = wanted - now
                arriving, integral[r] = pid_step(off, error[r], integral[r], kp[own], ti[own], td[own], most, h)
                error[r] = off
            if length:
                # What enters the pipe now arrives after the dead time of this road; until something else enters, it
                # lasts.
                entering, first = arriving, pipe[r, 0]
                for j in range(length):
                    pipe[r, j] = entering if j >= min(delay[k], length) - 1 else pipe[r, j + 1]
                if delay[k] > 0:
                    arriving = min(first, entering) if open_loop else first
            after = min(max(now + min(max((arriving - now) * follow, fall), rise), 0.0), limit[k])
            lost += (now + after) / 2 * h
            now = after
        decel[r] = now
        result[k] = lost / dt
    return result


@kernel
def pid_step(
    error: float, last: float, integral: float, kp: float, ti: float, td: float, limit: float, dt: float
) -> tuple[float, float]:
    """One step of `a_con = Kp [e + 1/Ti int e dt + Td de/dt]` (Zhao et al. 2025, eq. 7).

    Args:
        error: demanded less actual deceleration [m/s2] ...
        last: ... and that of the step before.
        integral: of the error, so far [m/s].
        kp: gain.
        ti: integral time [s].
        td: derivative time [s].
        limit: of the controlled deceleration, at which the integral stops [m/s2].
        dt: step [s].

    Returns:
        The controlled deceleration, 0 to `limit` [m/s2], and the new integral.
    """
    grown = integral + error * dt
    wanted = kp * (error + grown / ti + td * (error - last) / dt)
    controlled = min(max(wanted, 0.0), limit)
    beyond = wanted - controlled
    winding_up = (beyond > 0 and error > 0) or (beyond < 0 and error < 0)
    return controlled, integral if winding_up else grown
