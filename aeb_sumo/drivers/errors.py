"""The error layer: who errs when, and what they do meanwhile.

What a driver draws is fixed by the seed and his own name, on his own clock from departure; the AEB, other vehicles and
the state of traffic change no draw. Whether a drawn glance takes place depends on the moment: see
`aeb_sumo.world.surroundings.demanding`.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from heapq import heappop, heappush
from typing import ClassVar

import numpy as np
from scipy.stats import norm

from aeb_sumo.drivers.streams import stream
from aeb_sumo.soa import Bools, Floats, fitted

__all__ = ["PROFILES", "Errors", "FailureToYield", "Glances", "HardBraking", "Lapse", "Lapses", "Robots"]


@dataclass(frozen=True)
class Lapse:
    """A stretch of time in which a driver does not do what he should: from `start` to `end` [s] he keeps `accel`."""

    start: float
    end: float
    accel: float


@dataclass(frozen=True, kw_only=True)
class Glances:
    """Looking away: speed is held while the eyes are off the road and until the driver has reacted after that.

    Attributes:
        median: of the log-normal duration of a glance [s]; 0.8 from another source (evidence.md, R: 0.7 to 0.9).
        over_two: share of glances longer than 2 s; 0.05 from another source (evidence.md, R).
        share: share of time with the eyes off the road; 0.18 from another source (evidence.md, R: 0.15 to 0.20).
        reaction: from the eyes' return to the driver's response [s]; 0.75 from another source (UN R157, V).
    """

    name: ClassVar[str] = "glance"
    median: float = 0.8
    over_two: float = 0.05
    share: float = 0.18
    reaction: float = 0.75

    def lapses(self, draw: np.random.Generator, driver: str) -> Iterator[Lapse]:  # noqa: ARG002
        """One driver's lapses, on his clock from departure."""
        sigma = np.log(2.0 / self.median) / norm.isf(self.over_two)
        mean_off = self.median * np.exp(sigma**2 / 2)
        mean_on = mean_off * (1 - self.share) / self.share
        now = 0.0
        while True:
            now += draw.exponential(mean_on)
            away = draw.lognormal(np.log(self.median), sigma)
            yield Lapse(now, now + away + self.reaction, 0.0)
            now += away


@dataclass(frozen=True, kw_only=True)
class HardBraking:
    """Braking hard for a reason that no one behind can foresee.

    Attributes:
        every: mean time between two of them for one driver [s], our assumption: far more often than in life, so that a
            short run has conflicts.
        decel: [m/s2], our assumption.
        duration: [s], our assumption.
    """

    name: ClassVar[str] = "hard_braking"
    every: float = 300.0
    decel: float = 6.0
    duration: float = 2.0

    def lapses(self, draw: np.random.Generator, driver: str) -> Iterator[Lapse]:  # noqa: ARG002
        """One driver's lapses, on his clock from departure."""
        now = 0.0
        while True:
            now += draw.exponential(self.every)
            yield Lapse(now, now + self.duration, -self.decel)


@dataclass(frozen=True, kw_only=True)
class Robots:
    """Driving robots, as on a proving ground: they never react, and hold their speed but for what they are told to do.

    Attributes:
        programs: (vehicle, lapses) of those that do not just hold their speed: what they do instead and when, one lapse
            after the other from departure on.
    """

    name: ClassVar[str] = "robot"
    programs: tuple[tuple[str, tuple[Lapse, ...]], ...] = ()

    def lapses(self, draw: np.random.Generator, driver: str) -> Iterator[Lapse]:  # noqa: ARG002
        """What a robot does, on its clock from departure: its program, then holding its speed without end."""
        now = 0.0
        for lapse in dict(self.programs).get(driver, ()):
            yield Lapse(now, lapse.start, 0.0)
            yield lapse
            now = lapse.end
        yield Lapse(now, np.inf, 0.0)


@dataclass(frozen=True, kw_only=True)
class FailureToYield:
    """Turning left without a look for oncoming two-wheelers: one draw per driver and turn.

    Attributes:
        probability: that a driver does not look, our assumption: far more often than in life, so that a short run has
            conflicts.
        rider_unaware: that a rider whom such a driver overlooks relies on the right of way and does not react to the
            moving car, one draw per driver and rider, our assumption.
        rider_reaction: such a rider does react to a car that has been standing for this long [s]; 0.92, the mean
            reaction to a crossing conflict, from another source (de Gelder, V in evidence.md).
    """

    name: ClassVar[str] = "failure_to_yield"
    probability: float = 0.5
    rider_unaware: float = 0.5
    rider_reaction: float = 0.92

    def driver_fails(self, seed: int, driver: str, junction: str) -> bool:
        """Whether this driver does not look at this junction."""
        return bool(stream(seed, self.name, driver, junction).random() < self.probability)

    def rider_fails(self, seed: int, driver: str, rider: str) -> bool:
        """Whether this rider does not react to this driver."""
        return bool(stream(seed, self.name, driver, "rider", rider).random() < self.rider_unaware)


@dataclass(frozen=True, kw_only=True)
class Errors:
    """Which errors the drivers of a scenario make; None for an error they do not make."""

    glances: Glances | None = None
    hard_braking: HardBraking | None = None
    failure_to_yield: FailureToYield | None = None
    robots: Robots | None = None

    def names(self) -> str:
        """The errors by name, for the tables: `glance+hard_braking`, or `attentive` for none."""
        made = (self.glances, self.hard_braking, self.failure_to_yield, self.robots)
        return "+".join(error.name for error in made if error is not None) or "attentive"


PROFILES: dict[str, Errors] = {
    "attentive": Errors(),
    "distracted": Errors(glances=Glances(), hard_braking=HardBraking(), failure_to_yield=FailureToYield()),
}
"""Errors by name, for scenarios that bring none of their own."""


@dataclass(order=True)
class _Event:
    time: float
    order: int
    slot: int = field(compare=False)
    vehicle: str = field(compare=False)
    kind: int = field(compare=False)
    lapse: Lapse = field(compare=False)
    starts: bool = field(compare=False)


class Lapses:
    """All drivers' lapses in the order of time, event by event from a heap.

    Attributes:
        kinds: the errors that are lapses, in order of precedence: the first that is on decides what a driver does.
        on: (slots, kinds) which lapses are on now.
        accel: (slots, kinds) what the driver does in them [m/s2].
        looked_away: slots of those whose glance began with the last `advance`.
    """

    def __init__(self, errors: Errors, seed: int) -> None:
        self.kinds = [e for e in (errors.hard_braking, errors.glances, errors.robots) if e is not None]
        self._seed = seed
        self._heap: list[_Event] = []
        self._count = 0
        self._streams: dict[str, list[Iterator[Lapse]]] = {}
        self._departed: dict[str, float] = {}
        self.looked_away: list[int] = []
        self.on: Bools = np.zeros((0, len(self.kinds)), np.bool_)
        self.accel: Floats = np.zeros((0, len(self.kinds)))

    def depart(self, slot: int, vehicle: str, time: float) -> None:
        """A driver who may err begins his trip."""
        if not self.kinds:
            return
        self.fit(slot + 1)
        self._departed[vehicle] = time
        self._streams[vehicle] = [k.lapses(stream(self._seed, k.name, vehicle), vehicle) for k in self.kinds]
        for kind in range(len(self.kinds)):
            self._next(slot, vehicle, kind)

    def leave(self, slot: int, vehicle: str) -> None:
        """A driver's trip ends."""
        if self._departed.pop(vehicle, None) is not None:
            del self._streams[vehicle]
            self.on[slot] = False

    def advance(self, time: float) -> None:
        """Bring `on` and `accel` to `time` [s]."""
        self.looked_away = []
        while self._heap and self._heap[0].time <= time:
            event = heappop(self._heap)
            if event.vehicle not in self._departed:
                continue
            self.on[event.slot, event.kind] = event.starts
            if event.starts:
                self.accel[event.slot, event.kind] = event.lapse.accel
                if self.kinds[event.kind].name == Glances.name:
                    self.looked_away.append(event.slot)
                self._push(event.lapse.end, event, starts=False)
            else:
                self._next(event.slot, event.vehicle, event.kind)

    def fit(self, size: int) -> None:
        """Make room for `size` slots."""
        self.on, self.accel = fitted(self.on, size), fitted(self.accel, size)

    def erring(self) -> tuple[Bools, Floats, Bools]:
        """Per slot: in a lapse; acceleration in it [m/s2]; looking away and nothing else."""
        size = len(self.on)
        if not self.kinds:
            return np.zeros(size, np.bool_), np.zeros(size), np.zeros(size, np.bool_)
        first = self.on.argmax(1)
        any_on: Bools = np.any(self.on, axis=1)
        looks = np.array([k.name == Glances.name for k in self.kinds])
        away: Bools = any_on & looks[first]
        return any_on, np.take_along_axis(self.accel, first[:, None], 1)[:, 0], away

    def name(self, slot: int) -> str:
        """The error a driver is making, or empty."""
        return self.kinds[int(self.on[slot].argmax())].name if self.kinds and self.on[slot].any() else ""

    def _next(self, slot: int, vehicle: str, kind: int) -> None:
        lapse = next(self._streams[vehicle][kind])
        begin = self._departed[vehicle]
        lapse = Lapse(begin + lapse.start, begin + lapse.end, lapse.accel)
        event = _Event(lapse.start, 0, slot, vehicle, kind, lapse, True)
        self._push(lapse.start, event, starts=True)

    def _push(self, time: float, event: _Event, *, starts: bool) -> None:
        self._count += 1
        heappush(self._heap, _Event(time, self._count, event.slot, event.vehicle, event.kind, event.lapse, starts))
