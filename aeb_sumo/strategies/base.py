"""What every strategy takes and gives. All arrays are (n,), one row per equipped vehicle, SI units."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from enum import Enum, IntEnum
from typing import Any, ClassVar

import numpy as np

from aeb_sumo.parameters import check
from aeb_sumo.soa import Bools, Floats, Ints
from aeb_sumo.vehicle.brake import BrakeParams

__all__ = ["Demand", "Gaze", "Percept", "Phase", "Strategy"]


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


class Gaze(Enum):
    """Which of all that it sees a system takes for its target."""

    PATH = "path"
    """Who is, or will be, in the way on the own planned path: the lead, or crossing traffic, the nearest of them."""
    RELATIVE_MOTION = "relative motion"
    """Who will pass closest ahead if both go on in a straight line: no knowledge of anybody's path."""
    LEAD = "lead"
    """Who is ahead on the own path and goes the same way: a car-following system, blind to crossing traffic."""

    @property
    def sees_crossing(self) -> bool:
        """Whether crossing traffic can be a target."""
        return self is not Gaze.LEAD


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
        ahead, left: where the target is, in the frame of the own front bumper [m].
        closing_ahead, closing_left: own velocity less the target's, in that frame [m/s].
        vulnerable: the target is a two-wheeler or a pedestrian.
        mu: friction coefficient of the road, as the vehicle knows it.
    """

    valid: Bools
    gap: Floats
    ego_speed: Floats
    ego_accel: Floats
    target_speed: Floats
    target_accel: Floats
    ahead: Floats
    left: Floats
    closing_ahead: Floats
    closing_left: Floats
    vulnerable: Bools
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


@dataclass(frozen=True, kw_only=True)
class Strategy(ABC):
    """A pure function of arrays with explicit state; it knows nothing of SUMO, ids or other vehicles.

    Its fields are its parameters; those that are numbers are checked against the range that
    `aeb_sumo.parameters.within` gives them, else to be finite and not negative. `step` must not change its inputs and
    must treat every row alone. The laws that hold for all strategies are in tests/contract/test_strategies.py.

    Attributes:
        brake: brake and lower controller the system was published with.
    """

    name: ClassVar[str]
    """As on the command line."""
    source: ClassVar[str]
    """The publication."""
    sensing: ClassVar[str] = "ideal"
    """What it sees with, unless the run says otherwise: a suite of `aeb_sumo.perception.suites`."""
    gaze: ClassVar[Gaze] = Gaze.PATH
    """How it chooses its target."""
    estimates_friction: ClassVar[bool] = False
    """`Percept.mu` is its own running estimate; otherwise it is told the truth."""

    brake: BrakeParams = field(default_factory=BrakeParams)

    @property
    def sees_crossing(self) -> bool:
        """Whether crossing traffic can be its target."""
        return self.gaze.sees_crossing

    @property
    def friction_prior(self) -> float | None:
        """What a vehicle that estimates friction takes it for when it enters; None: the truth of that place."""
        return None

    @property
    def cycle(self) -> float:
        """Time between two steps of the system [s], counted from its vehicle's departure, our assumption.

        0: one in every step of the simulation. Sensors have a cycle of their own.
        """
        return 0.0

    def longest_ttc(self, mu: float) -> float:  # noqa: ARG002
        """The longest time to collision at which it acts on a road of friction `mu` [s], closing in with up to 40 m/s.

        A target farther away need not be watched in every step. 4: our assumption.
        """
        return 4.0

    def __post_init__(self) -> None:
        """Raises `InputError` for a parameter out of range."""
        check(self)

    @abstractmethod
    def init(self, n: int) -> Any:
        """State of `n` vehicles that have seen nothing yet: a dataclass of arrays (see `aeb_sumo.soa`)."""

    @abstractmethod
    def step(self, state: Any, percept: Percept, dt: float) -> tuple[Any, Demand]:
        """One step of `dt` [s]: the new state and the demand that holds until the next."""
