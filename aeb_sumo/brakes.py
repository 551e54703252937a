"""The brakes of all equipped vehicles, by slot."""

import numpy as np

from aeb_sumo.compiled import kernel
from aeb_sumo.soa import Bools, Floats, Ints, fitted, put
from aeb_sumo.vehicle.brake import BrakeParams, brake_in_place, brake_init
from aeb_sumo.world.friction import Friction
from aeb_sumo.world.observe import Traffic

__all__ = ["Brakes"]

_RELEASED = 0.05  # m/s2, a brake below this is off
_HOLDING = 3.0  # m/s2, of a brake that holds a standing car: any value holds it


class Brakes:
    """What the AEBs' brakes do, on the road there is; and that they hold a car which they have brought to a stop."""

    def __init__(self, traffic: Traffic, friction: Friction, params: BrakeParams) -> None:
        self._traffic, self._friction, self._params = traffic, friction, params
        self._state = brake_init(params, 0, traffic.dt)
        self._hold: Floats = np.zeros(0)  # for how long yet [s]

    def fit(self, size: int) -> None:
        """Make room for so many slots."""
        grown = brake_init(self._params, size, self._traffic.dt)
        put(grown, np.arange(len(self._hold)), self._state)
        self._state, self._hold = grown, fitted(self._hold, size)

    def reset(self, rows: Ints) -> None:
        """Release them, at once."""
        put(self._state, rows, brake_init(self._params, len(rows), self._traffic.dt))
        self._hold[rows] = 0.0

    def working(self, rows: Ints) -> Bools:
        """(n,) brakes that are on, hold a standing car, or have something on the way to them."""
        return _working(rows, self._state.decel, self._hold, self._state.pipe)

    def apply(self, rows: Ints, demand: Floats, decel: Floats) -> None:
        """One step of the vehicles in slots `rows`.

        Args:
            rows: slots.
            demand: (n,) of their systems, >= 0 [m/s2].
            decel: per slot, mean deceleration over the step [m/s2]; written to where a brake works.
        """
        t, dt, state, params = self._traffic, self._traffic.dt, self._state, self._params
        braking, wanted = _wanted(
            rows, demand, t.speed, t.old_speed, state.decel, state.pipe, self._hold, params.hold, dt
        )
        if not len(braking):
            return
        braked = brake_in_place(params, state, braking, demand=wanted, mu=self._friction.at(braking), dt=dt)
        idle = _applied(braking, wanted, braked, t.speed, state.pipe, self._hold, decel)
        if len(idle):
            put(state, idle, brake_init(params, len(idle), dt))


@kernel
def _is_on(slot: int, decel: Floats, hold: Floats, pipe: Floats) -> bool:
    """The brake is on, holds a standing car, or has something on the way to it."""
    return decel[slot] > _RELEASED or hold[slot] > 0 or _on_the_way(slot, pipe)


@kernel
def _on_the_way(slot: int, pipe: Floats) -> bool:
    return bool((pipe[slot] > 0).any())


@kernel
def _working(rows: Ints, decel: Floats, hold: Floats, pipe: Floats) -> Bools:
    result = np.empty(len(rows), np.bool_)
    for k in range(len(rows)):
        result[k] = _is_on(rows[k], decel, hold, pipe)
    return result


@kernel
def _wanted(
    rows: Ints, demand: Floats, speed: Floats, old_speed: Floats, decel: Floats, pipe: Floats, hold: Floats,
    longest: float, dt: float,
) -> tuple[Ints, Floats]:  # fmt: skip
    """Which brakes are in use, and what is asked of them; `hold` is brought up to date."""
    braking, wanted, n = np.empty(len(rows), np.int64), np.empty(len(rows)), 0
    for k in range(len(rows)):
        slot = rows[k]
        if not (demand[k] > 0 or _is_on(slot, decel, hold, pipe)):
            continue
        # Brought to a stop by its AEB, a car is held for a while; its driver then takes over.
        stopped = speed[slot] <= 0 and old_speed[slot] > 0 and decel[slot] > _RELEASED
        hold[slot] = longest if stopped else max(hold[slot] - dt, 0.0)
        braking[n], wanted[n] = slot, max(demand[k], _HOLDING) if hold[slot] > 0 else demand[k]
        n += 1
    return braking[:n], wanted[:n]


@kernel
def _applied(
    rows: Ints, wanted: Floats, braked: Floats, speed: Floats, pipe: Floats, hold: Floats, decel: Floats
) -> Ints:
    """Write what the brakes of these rows do into `decel`; the slots of those that have nothing more to do."""
    idle, n = np.empty(len(rows), np.int64), 0
    for k in range(len(rows)):
        slot = rows[k]
        does = braked[k] if speed[slot] > 0 else (_HOLDING if hold[slot] > 0 else 0.0)
        decel[slot] = does if does > _RELEASED else 0.0
        if decel[slot] == 0 and wanted[k] == 0 and not _on_the_way(slot, pipe):
            idle[n] = slot
            n += 1
    return idle[:n]
