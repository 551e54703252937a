"""What every strategy takes and gives. All arrays are (n,), one row per equipped vehicle, SI units."""

from dataclasses import dataclass
from enum import IntEnum
from typing import Any, ClassVar, Protocol

import numpy as np

from aeb_sumo.soa import Bools, Floats, Ints
from aeb_sumo.vehicle.brake import BrakeParams

__all__ = ["Demand", "Percept", "Phase", "Strategy"]


class Phase(IntEnum):
    """What the system is doing."""

    NONE = 0
    """Nothing."""
    WARN = 1
    """Warning the driver, no braking."""
    PARTIAL_BRAKE = 2
    """Braking below the system's maximum."""
    FULL_BRAKE = 3
    """Braking with all the system allows itself."""


@dataclass(frozen=True, kw_only=True)
class Percept:
    """What an equipped vehicle knows of itself and of its target.

    Attributes:
        valid: there is a confirmed target; where False, the target's numbers mean nothing.
        gap: bumper to bumper along the own path [m].
        ego_speed: own speed [m/s].
        ego_accel: own acceleration, signed [m/s2].
        target_speed: speed of the target along the own path [m/s]; 0 for one that crosses it.
        target_accel: acceleration of the target along the own path, signed [m/s2].
        mu: friction coefficient of the road, as the vehicle knows it.
    """

    valid: Bools
    gap: Floats
    ego_speed: Floats
    ego_accel: Floats
    target_speed: Floats
    target_accel: Floats
    mu: Floats


@dataclass(frozen=True, kw_only=True)
class Demand:
    """What a strategy asks for.

    Attributes:
        phase: a `Phase` per row.
        decel: deceleration demanded, >= 0 [m/s2]; 0 below `Phase.PARTIAL_BRAKE`.
    """

    phase: Ints
    decel: Floats

    @classmethod
    def nothing(cls, n: int) -> "Demand":
        """No demand for `n` rows."""
        return cls(phase=np.zeros(n, np.int64), decel=np.zeros(n))


class Strategy(Protocol):
    """A pure function of arrays with explicit state; it knows nothing of SUMO, ids or other vehicles.

    `step` must not change its inputs and must treat every row alone. The laws that hold for all strategies are in
    tests/contract/test_strategies.py.
    """

    name: ClassVar[str]
    """As on the command line."""
    source: ClassVar[str]
    """The publication."""

    @property
    def brake(self) -> BrakeParams:
        """The brake and lower controller the system was published with."""
        ...

    def init(self, n: int) -> Any:
        """State of `n` vehicles that have seen nothing yet: a dataclass of arrays (see `aeb_sumo.soa`)."""
        ...

    def step(self, state: Any, percept: Percept, dt: float) -> tuple[Any, Demand]:
        """One step of `dt` [s]: the new state and the demand that holds until the next."""
        ...
