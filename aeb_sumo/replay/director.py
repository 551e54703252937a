"""Both worlds of an event on film: a recorder that looks on while the run is simulated again, and forks it."""

from dataclasses import dataclass

from aeb_sumo.engine import Engine
from aeb_sumo.ledger.conflicts import Conflicts
from aeb_sumo.replay.event import Event
from aeb_sumo.replay.film import Camera, Film
from aeb_sumo.verdicts.book import WINDOW
from aeb_sumo.verdicts.judge import Outcome
from aeb_sumo.verdicts.witness import Witness
from aeb_sumo.world.fork import Answer, Forks, obstacle
from aeb_sumo.world.kinds import VClasses

__all__ = ["LEAD", "Director", "World"]

LEAD = 5.0
"""How long before a crash an AEB is put into vehicles that had none [s], our assumption."""

_RUN_UP = 1.0  # s of film before the worlds part, at least


@dataclass(frozen=True)
class World:
    """What became of one world: the film, and what happened to the ego and those behind it.

    Attributes:
        film: what was to be seen.
        outcome: as a verdict has it, in its window.
        equipped: ids of those who got an AEB.
    """

    film: Film
    outcome: Outcome
    equipped: tuple[str, ...] = ()


class Director:
    """A recorder (`aeb_sumo.trace.Recorder`) that films an event, and the world in which it is otherwise.

    Args:
        event: what is filmed.
        mu: friction coefficient of the road.
        before, after: film before and after the event [s].

    Attributes:
        forking: when the world is forked [s]: when the intervention begins, for its warning may reach the driver at any
            time from then on; or so long before a crash without one.
        end: of the film [s].
        done: the film of this world is complete.
    """

    def __init__(self, event: Event, *, mu: float, before: float, after: float) -> None:
        self._event, self._mu = event, mu
        self.forking = event.instant - LEAD if event.intervention is None else float(event.intervention["begin_s"])
        self._start = min(event.instant - before, self.forking - _RUN_UP)
        self.end = max(event.end + after, self.forking + WINDOW)
        self.done = False
        self._forks = Forks()
        self._fork: int | None = None
        self._obstacle = "the two were never on the road together"
        self._witness: Witness | None = None
        self._equipped: tuple[str, ...] = ()
        self._engine: Engine
        self._camera: Camera
        self._conflicts: Conflicts
        self._factual: World | None = None

    def attend(self, world: Engine) -> None:
        """A run begins."""
        self._engine = world
        self._camera = Camera(world, self._event.ego, self._event.other)
        self._conflicts = Conflicts(world.traffic, world.error, self._mu)

    def step(self, time: float) -> None:
        """Film this step, and let the worlds part if it is time for it."""
        half = self._engine.traffic.dt / 2
        if self.done or time < self._start - half:
            return
        self._look()
        ego = self._camera.slot(self._event.ego)
        if self._witness is None and time > self.forking - half and ego is not None:
            self._witness = Witness(self._engine, self._conflicts, ego)
        if self._fork is None and time > self.forking - half and self._ready():
            self._part()
        if time > self.end - half:
            self.done = True
            self._factual = self._world()

    def worlds(self) -> tuple[World, Answer]:
        """The world as it was, and the other one, a `World`, or why there is none."""
        answers = self._forks.answers(wait=True)
        # Where SUMO gave up before the end, there was nobody left to ask for the road.
        factual = self._factual or World(self._camera.film, self._outcome())
        return factual, Answer(failure=self._obstacle) if self._fork is None else answers[self._fork]

    def end_forks(self) -> None:
        """Give up the other world, if it is still out."""
        self._forks.end("the film is over")

    def _look(self) -> None:
        """The books of a step."""
        engine, conflicts = self._engine, self._conflicts
        for crash in engine.crashes:
            conflicts.crash(crash.impact.striker, crash.impact.struck)
        conflicts.step(engine.time, engine.leads, engine.paths.crossings, engine.wrecks.wrecked, engine.fleet.equipped)
        self._camera.take()
        if self._witness is not None and engine.time < self.forking + WINDOW + engine.traffic.dt / 2:
            self._witness.step()

    def _ready(self) -> bool:
        """Whether the world can be made another one now."""
        if self._event.intervention is not None:
            return self._camera.slot(self._event.ego) is not None
        return None not in (self._camera.slot(self._event.ego), self._camera.slot(self._event.other))

    def _part(self) -> None:
        self._obstacle = obstacle() or self._nobody()
        if not self._obstacle:
            self._fork = self._forks.split(self._otherwise)

    def _nobody(self) -> str:
        """Why there is nothing to change; empty if there is."""
        if self._event.intervention is not None or self._without():
            return ""
        t, slots = self._engine.traffic, (self._camera.slot(self._event.ego), self._camera.slot(self._event.other))
        if any(slot is not None and t.vclass[slot] in VClasses.DRIVEN for slot in slots):
            return "who of the two can carry an AEB has one, and it did not act"
        return "neither of the two can carry an AEB"

    def _without(self) -> list[int]:
        """Slots of those of the two that can carry an AEB and have none."""
        engine, slots = self._engine, [self._camera.slot(name) for name in (self._event.ego, self._event.other)]
        return [
            slot
            for slot in slots
            if slot is not None
            and engine.traffic.vclass[slot] in VClasses.DRIVEN
            and not engine.fleet.system(slot)
            and not engine.wrecks.wrecked[slot]
        ]

    def _otherwise(self) -> World:
        """The life of the fork."""
        engine = self._engine
        if self._event.intervention is None:
            slots = self._without()
            self._equipped = tuple(engine.traffic.ids[slot] for slot in slots)
            for slot in slots:
                engine.equip(slot, self._event.system.name)
        else:
            engine.suppress(engine.traffic.slot[self._event.ego])
        self._camera.retake()
        engine.act()
        while engine.time < self.end - engine.traffic.dt / 2:
            engine.observe()
            engine.decide()
            self._look()
            engine.act()
        return self._world()

    def _world(self) -> World:
        return World(self._camera.cut(), self._outcome(), self._equipped)

    def _outcome(self) -> Outcome:
        return Outcome() if self._witness is None else self._witness.outcome()
