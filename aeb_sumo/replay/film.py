"""A film of one world: frame by frame, what all do around two vehicles, and who crashes."""

from dataclasses import dataclass, field

import numpy as np

from aeb_sumo.engine import Engine
from aeb_sumo.soa import Bools, Floats, Ints
from aeb_sumo.world.boxes import Boxes, distance
from aeb_sumo.world.scenery import Scenery, lights, scenery
from aeb_sumo.world.wrecks import Crash

__all__ = ["Body", "Camera", "Contact", "Film", "Frame"]

_REACH = 150.0  # m around the two, our assumption: as far as any sensor sees
_MARGIN = 60.0  # m of road around them in a film


@dataclass(frozen=True)
class Body:
    """What does not change of a road user: SUMO's vehicle class, length and width [m]."""

    vclass: str
    length: float
    width: float


@dataclass(frozen=True, kw_only=True)
class Frame:
    """One instant.

    Attributes:
        time: [s].
        ids: of the road users, n of them.
        x, y, heading, speed: (n,) front bumper [m], mathematical angle [rad], [m/s].
        accel: (n,) of the step before [m/s2].
        brake: (n,) deceleration by the AEB in the step to come [m/s2].
        phase: (n,) of the AEB, a `Phase`.
        wrecked: (n,).
        lights: traffic light -> its state, in SUMO's letters.
    """

    time: float
    ids: tuple[str, ...]
    x: Floats
    y: Floats
    heading: Floats
    speed: Floats
    accel: Floats
    brake: Floats
    phase: Ints
    wrecked: Bools
    lights: dict[str, str]


@dataclass(frozen=True, kw_only=True)
class Contact:
    """A crash: when [s] and where [m], who, and how fast (magnitude of the relative velocity) [m/s]."""

    time: float
    x: float
    y: float
    striker: str
    struck: str
    speed: float

    @classmethod
    def of(cls, crash: Crash) -> "Contact":
        """From the world's own."""
        hit = crash.impact
        return cls(time=hit.time, x=hit.x, y=hit.y, striker=crash.striker, struck=crash.struck, speed=hit.impact_speed)


@dataclass
class Film:
    """What a camera has taken.

    Attributes:
        frames: in the order of time, one per step.
        cast: who is in it, by id.
        contacts: all crashes among them.
        scenery: what stands around.
    """

    frames: list[Frame] = field(default_factory=list)
    cast: dict[str, Body] = field(default_factory=dict)
    contacts: list[Contact] = field(default_factory=list)
    scenery: Scenery | None = None

    @property
    def times(self) -> Floats:
        """(n,) of the frames [s]."""
        return np.array([frame.time for frame in self.frames])

    def curve(self, name: str, what: str) -> Floats:
        """(n,) a value of one road user, by the name it has in `Frame`; nan where he is not near."""
        found = [getattr(f, what)[f.ids.index(name)] if name in f.ids else np.nan for f in self.frames]
        return np.array(found, float)

    def gap(self, one: str, other: str) -> Floats:
        """(n,) distance of two bodies [m]; nan where they are not both near."""
        if not {one, other} <= self.cast.keys():
            return np.full(len(self.frames), np.nan)
        boxes = []
        for name in (one, other):
            x, y, heading = (self.curve(name, what) for what in ("x", "y", "heading"))
            body = self.cast[name]
            boxes.append(Boxes.of(x, y, heading, np.full(len(x), body.length), np.full(len(x), body.width)))
        return distance(*boxes)


class Camera:
    """Films two road users and all around them.

    Args:
        engine: the world.
        ego, other: the two, by id; the other may be nobody.

    Attributes:
        film: so far.
    """

    def __init__(self, engine: Engine, ego: str, other: str) -> None:
        self._engine, self._two = engine, (ego, other)
        self._centres: dict[str, Floats] = {}  # where they were last
        self.film = Film()

    def slot(self, name: str) -> int | None:
        """Of a vehicle or a person on foot; None when it is not there."""
        t = self._engine.traffic
        if name in t.slot:
            return t.slot[name] if t.here[t.slot[name]] else None
        return next((slot for slot in t.walkers.tolist() if t.ids[slot] == name), None)

    def take(self) -> None:
        """Take the frame of now, between decision and deed."""
        self.film.frames.append(self._frame())
        self.film.contacts += [
            Contact.of(crash) for crash in self._engine.crashes if {crash.striker, crash.struck} & self.film.cast.keys()
        ]

    def retake(self) -> None:
        """Take the last frame once more: something has been changed in it."""
        self.film.frames[-1] = self._frame()

    def _frame(self) -> Frame:
        t, fleet = self._engine.traffic, self._engine.fleet
        t.read(t.present)
        for name in self._two:
            slot = self.slot(name)
            if slot is not None:
                self._centres[name] = np.array([t.x[slot], t.y[slot]])
        rows = np.concatenate([t.present, t.walkers])
        near = np.zeros(len(rows), np.bool_)
        for x, y in self._centres.values():
            near |= np.hypot(t.x[rows] - x, t.y[rows] - y) <= _REACH
        rows = rows[near & t.here[rows]]
        for slot in rows.tolist():
            body = Body(t.vclass[slot], float(t.length[slot]), float(t.width[slot]))
            self.film.cast.setdefault(t.ids[slot], body)
        return Frame(
            time=self._engine.time,
            ids=tuple(t.ids[slot] for slot in rows.tolist()),
            **{name: getattr(t, name)[rows] for name in ("x", "y", "heading", "speed", "accel")},
            brake=fleet.decel[rows],
            phase=fleet.demand.phase[rows],
            wrecked=self._engine.wrecks.wrecked[rows],
            lights=lights(),
        )

    def cut(self) -> Film:
        """The film, with what stands around; the last thing."""
        points = [np.column_stack([f.x, f.y]) for f in self.film.frames if len(f.x)]
        if points:
            all_ = np.vstack(points)
            self.film.scenery = scenery(all_.min(0) - _MARGIN, all_.max(0) + _MARGIN)
        return self.film
