"""Lapses: stretches of time in which a driver does not do what he should, whatever the traffic around him does.

What a driver draws is fixed by the seed and his own name, on his own clock from departure; the AEB, other vehicles and
the state of traffic change no draw. Whether a drawn glance takes place depends on the moment: drivers choose calm ones.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from typing import ClassVar, NamedTuple

import numpy as np
from scipy.special import ndtri

from aeb_sumo.compiled import kernel
from aeb_sumo.drivers.streams import stream
from aeb_sumo.parameters import check, within
from aeb_sumo.soa import Bools, Floats, Ints, fitted

__all__ = ["Glances", "HardBraking", "Kind", "Lapse", "Lapses", "Robots"]

_DRAWS = 32  # glances at a time: one by one, drawing costs ten times as much
_AHEAD = 8  # glances of a driver that are looked ahead


class Lapse(NamedTuple):
    """A lapse from `start` to `end` [s], in which the driver keeps `accel` [m/s2]; nan: the one he had at its start."""

    start: float
    end: float
    accel: float


@dataclass(frozen=True, kw_only=True)
class Glances:
    """Looking away: the acceleration is held while the eyes are off the road.

    Attributes:
        median: of the log-normal duration of a glance [s]; 0.8 from another source (evidence.md, R: 0.7 to 0.9).
        over_two: share of glances longer than 2 s; 0.05 from another source (evidence.md, R).
        share: share of time with the eyes off the road; 0.18 from another source (evidence.md, R: 0.15 to 0.20).
        calm_ttc: nobody looks away while the TTC to the vehicle ahead is below this [s], our assumption.
        calm_headway: nor while following it at less than this [s], our assumption.
        calm_accel: nor while braking or speeding up harder than this [m/s2], our assumption.
        calm_lane: nor with less than this to go in a lane that leads off the route [m], our assumption.
    """

    name: ClassVar[str] = "glance"
    median: float = within(0.8, 0.05, 20.0)
    over_two: float = within(0.05, 0.0001, 0.49)
    share: float = within(0.18, 0.0, 0.9)
    calm_ttc: float = 8.0
    calm_headway: float = 0.5
    calm_accel: float = 1.0
    calm_lane: float = 500.0

    def __post_init__(self) -> None:
        """Raises `InputError` for a parameter out of range."""
        check(self)

    def lapses(self, draw: np.random.Generator, driver: str) -> Iterator[Lapse]:  # noqa: ARG002
        """One driver's lapses, on his clock from departure."""
        mean_on, log_median, sigma = self._moments
        now = 0.0
        while self.share > 0:
            on, off = draw.exponential(mean_on, _DRAWS).tolist(), draw.lognormal(log_median, sigma, _DRAWS).tolist()
            for eyes_on, away in zip(on, off, strict=True):
                now += eyes_on
                yield Lapse(now, now + away, np.nan)
                now += away

    @cached_property
    def _moments(self) -> tuple[float, float, float]:
        """Mean time with the eyes on the road [s], and of the glances the logarithm of their median and its spread."""
        # For a median of 2 s or more, half of the glances are longer than that whatever is asked for.
        sigma = max(float(np.log(2.0 / self.median) / -ndtri(self.over_two)), 0.05)
        mean_off = self.median * float(np.exp(sigma**2 / 2))
        mean_on = mean_off * (1 - self.share) / self.share if self.share > 0 else np.inf
        return mean_on, float(np.log(self.median)), sigma


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
    every: float = within(300.0, 1.0, 1e9)
    decel: float = within(6.0, 0.1, 12.0)
    duration: float = within(2.0, 0.1, 60.0)

    def __post_init__(self) -> None:
        """Raises `InputError` for a parameter out of range."""
        check(self)

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


Kind = HardBraking | Glances | Robots


class Lapses:
    """All drivers' lapses.

    Attributes:
        kinds: in order of precedence: the first that is on decides what a driver does.
        on: (slots, kinds) which lapses are on now.
        accel: (slots, kinds) what the driver does in them [m/s2], nan: hold the acceleration.
        glance: index of the glances among the kinds, or None.
        looked_away, looked_back: slots of those whose glance began, or ended, with the last `advance`.
        changed: of those of whom another lapse did.
        decisive: slot -> index of the kind that decides what a driver does now, glances apart.
    """

    def __init__(self, kinds: Sequence[Kind | None], seed: int) -> None:
        self.kinds: list[Kind] = [k for k in kinds if k is not None]
        self.glance = next((i for i, kind in enumerate(self.kinds) if isinstance(kind, Glances)), None)
        self._seed = seed
        # Per slot and kind, in one row: all lapses, the next of them as start, end [s] and acceleration, which of these
        # starts and ends is to come, and when it does; nan when all have been.
        self._lapses: dict[int, Iterator[Lapse]] = {}
        self._ahead: Floats = np.zeros((0, _AHEAD, 3))
        self._at: Ints = np.zeros(0, np.int64)
        self._due: Floats = np.zeros(0)
        self._told: Ints = np.zeros(0, np.int64)
        self._departed: dict[int, float] = {}
        self.looked_away: list[int] = []
        self.looked_back: list[int] = []
        self.changed: list[int] = []
        self.decisive: dict[int, int] = {}
        self.on: Bools = np.zeros((0, len(self.kinds)), np.bool_)
        self.accel: Floats = np.zeros((0, len(self.kinds)))

    def depart(self, slot: int, vehicle: str, time: float) -> None:
        """A driver who may err begins his trip."""
        self.fit(slot + 1)
        for row, kind in enumerate(self.kinds, slot * len(self.kinds)):
            self._lapses[row], self._departed[row] = kind.lapses(stream(self._seed, kind.name, vehicle), vehicle), time
            self._look_ahead(row)

    def leave(self, slot: int) -> None:
        """A driver's trip ends; he may have been one who never errs."""
        for row in range(slot * len(self.kinds), (slot + 1) * len(self.kinds)):
            if self._lapses.pop(row, None) is not None:
                self._due[row] = np.inf
                self.on[slot] = False
        self.decisive.pop(slot, None)

    def advance(self, time: float) -> None:
        """Bring all to `time` [s]."""
        self.looked_away, self.looked_back, self.changed = [], [], []
        while changes := _advance(time, self._due, self._at, self._ahead, self.on, self.accel, self._told):
            for change in self._told[:changes].tolist():
                row, ends = divmod(change, 2)
                slot, kind = divmod(row, len(self.kinds))
                if kind != self.glance:
                    self.changed.append(slot)
                elif ends:
                    self.looked_back.append(slot)
                else:
                    self.looked_away.append(slot)
            for row in np.isnan(self._due).nonzero()[0].tolist():
                self._look_ahead(row)
        for slot in self.changed:
            on = [kind for kind in self.on[slot].nonzero()[0].tolist() if kind != self.glance]
            self.decisive.pop(slot, None)
            if on:
                self.decisive[slot] = on[0]

    def _look_ahead(self, row: int) -> None:
        """Draw the next lapses."""
        some = _AHEAD if row % len(self.kinds) == self.glance else 1  # other lapses are rare
        lapses = list(islice(self._lapses[row], some))
        self._ahead[row] = np.inf if len(lapses) < some else np.nan
        if lapses:
            self._ahead[row, : len(lapses)] = lapses
            self._ahead[row, :, :2] += self._departed[row]
        self._at[row], self._due[row] = 0, self._ahead[row, 0, 0]

    def fit(self, size: int) -> None:
        """Make room for `size` slots."""
        self.on, self.accel = fitted(self.on, size), fitted(self.accel, size)
        rows, old = len(self.on) * len(self.kinds), len(self._due)
        self._ahead, self._at, self._due = (fitted(each, rows) for each in (self._ahead, self._at, self._due))
        self._due[old:] = np.inf
        self._told = fitted(self._told, rows * 2 * _AHEAD)


@kernel
def _advance(time: float, due: Floats, at: Ints, ahead: Floats, on: Bools, accel: Floats, told: Ints) -> int:
    """Begin and end lapses; how many times, and each of them as twice its row, plus one for an end."""
    changes = 0
    for row in range(len(due)):
        while due[row] <= time:
            slot, kind = row // on.shape[1], row % on.shape[1]
            lapse, ends = at[row] // 2, at[row] % 2
            on[slot, kind], accel[slot, kind] = ends == 0, ahead[row, lapse, 2]
            told[changes] = 2 * row + ends
            changes += 1
            at[row] += 1
            due[row] = ahead[row, at[row] // 2, at[row] % 2] if at[row] < 2 * _AHEAD else np.nan
    return changes
