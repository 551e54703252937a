"""The verdicts of a run: who is watched, when the world is forked, and what comes of it.

Until an intervention acts on the world, because the brake bites or the driver heeds the warning, the worlds with it and
without it are the same. So it is then that the world is forked, and one that never acts needs no fork. Whether a driver
heeds a warning shows later: the fork that is made when it reaches him sleeps until then.
"""

from functools import partial
from math import isfinite
from typing import Any

import numpy as np

from aeb_sumo.engine import Engine
from aeb_sumo.ledger.conflicts import Conflicts
from aeb_sumo.ledger.interventions import Intervention
from aeb_sumo.verdicts.choice import Choice, Reservoir
from aeb_sumo.verdicts.judge import Outcome, verdict
from aeb_sumo.verdicts.witness import Witness
from aeb_sumo.world.fork import Answer, Forks, obstacle

__all__ = ["WINDOW", "Verdicts"]

WINDOW = 10.0
"""How long after its beginning an intervention is compared with its absence [s], our assumption."""

SLEEPERS = 64
"""Forks that sleep at a time, our assumption: each is a process that holds what has changed in the world since. A
further one begins without delay, which gives the same."""


class _Watch:
    """An intervention on its way to a verdict.

    Attributes:
        fork: number of the fork in which it does not take place; None while there is none.
        asleep: the fork waits: a warning has reached the driver, who may do nothing but what he would do without it.
        acted_by, acted: what it first acted with, and when [s].
        with_, without: what happened, and what happened in the fork; None while that is not known.
        row: the verdict; None while there is none.
    """

    def __init__(self, intervention: Intervention, witness: Witness, engine: Engine, window: float) -> None:
        self.intervention, self.witness, self.window = intervention, witness, window
        self._engine, self._end = engine, engine.time + window
        self.fork: int | None = None
        self.asleep = False
        self.acted_by = ""
        self.acted: float | None = None
        self.with_: Outcome | None = None
        self.without: Answer | None = None
        self.row: dict[str, Any] | None = None

    def look(self) -> None:
        """See the step that has ended, and, if the window ends with it, what happened in it."""
        self.witness.step()
        if self._engine.time >= self._end - self._engine.traffic.dt / 2:
            self.with_ = self.witness.outcome()


class Verdicts:
    """Watches interventions and writes their verdicts into them.

    Args:
        engine: the world.
        conflicts: its book of conflicts.
        choice: which interventions get a verdict.
        forks: where the other worlds live.
        window: how long the worlds are compared [s].
        lazy: fork when an intervention acts on the world; otherwise at its beginning, which gives the same.
    """

    def __init__(
        self,
        engine: Engine,
        conflicts: Conflicts,
        *,
        choice: Choice,
        forks: Forks,
        window: float = WINDOW,
        lazy: bool = True,
    ) -> None:
        self._engine, self._conflicts, self._forks = engine, conflicts, forks
        self._window, self._lazy = window, lazy
        self._sampled = isfinite(choice.size)  # who has a place may yet lose it
        self._reservoir = Reservoir(choice.size, engine.session.seed)
        self._obstacle = obstacle()
        self._watches: dict[int, _Watch] = {}  # by the number of the intervention, from 0
        self._begun = 0

    def step(self, begun: list[tuple[int, Intervention]]) -> None:
        """Look on; the last thing before what has been decided is done.

        Args:
            begun: slots and interventions that begin with the coming step.
        """
        for watch in self._watches.values():
            if watch.with_ is None:
                watch.look()
        for slot, intervention in begun:
            self._begin(slot, intervention)
        for watch in self._watches.values():
            if watch.with_ is None and watch.without is None:
                self._fork_if_acting(watch)
            elif watch.asleep:
                self._dismiss(watch)
        self._settle(self._forks.answers())

    def finish(self, reason: str = "") -> None:
        """The run is over: all open verdicts are given.

        Args:
            reason: why it is over, if before its time; there is no use in waiting then.
        """
        if reason:
            self._forks.end(reason)
            for watch in self._watches.values():
                if watch.row is None:
                    watch.with_, watch.without = watch.witness.outcome(), Answer(failure=reason)
        late = {number: watch for number, watch in self._watches.items() if watch.with_ is None}
        for watch in late.values():
            self._wake(watch)
            if watch.fork is None and watch.without is None:  # it may act yet
                watch.fork = self._forks.split(partial(self._later, watch))
        # What the windows need that the run did not live to see, one more fork does.
        fork = self._forks.split(lambda: self._outlook(late)) if late and not self._obstacle else None
        answers = self._forks.answers(wait=True)
        seen = answers.pop(fork) if fork is not None else Answer(failure=self._obstacle)
        for number, watch in late.items():
            watch.with_ = watch.witness.outcome() if seen.failure else seen.value[number]
            if seen.failure:
                watch.fork, watch.without = None, Answer(failure=seen.failure)
        self._settle(answers)
        for watch in self._watches.values():
            watch.intervention.judge(watch.row or {})
        self._watches = {}

    def end_forks(self) -> None:
        """Give up all forks that are still out; for when there is no `finish`."""
        self._forks.end("the run is over")

    def _begin(self, slot: int, intervention: Intervention) -> None:
        number, self._begun = self._begun, self._begun + 1
        placed, loser = self._reservoir.offer()
        if loser is not None:
            watch = self._watches.pop(loser)
            self._dismiss(watch)
            watch.intervention.judge({})
        if not placed:
            intervention.judge({})
            return
        watch = _Watch(intervention, Witness(self._engine, self._conflicts, slot), self._engine, self._window)
        watch.without = Answer(failure=self._obstacle) if self._obstacle else None
        self._watches[number] = watch

    def _fork_if_acting(self, watch: _Watch) -> None:
        engine, slot, forks = self._engine, watch.witness.slot, self._forks
        if slot is None:
            self._dismiss(watch)
            return
        brakes = engine.fleet.decel[slot] > 0 and watch.intervention.open
        alerted = engine.motorists.alerted(slot, watch.intervention.span, by=engine.next_time)
        if watch.fork is None and (brakes or alerted or not self._lazy):
            watch.asleep = self._lazy and not brakes and forks.asleep < SLEEPERS
            watch.fork = forks.split(lambda: self._otherwise(watch, slot), asleep=watch.asleep)
        if not watch.acted_by and (brakes or (watch.fork is not None and slot in engine.heeded)):
            watch.acted_by, watch.acted = "brake" if brakes else "warning", engine.time
            self._wake(watch)
        elif not (alerted or engine.motorists.attentive[slot]):
            self._dismiss(watch)

    def _wake(self, watch: _Watch) -> None:
        if watch.asleep and watch.fork is not None:
            self._forks.wake(watch.fork)
            watch.asleep = False

    def _dismiss(self, watch: _Watch) -> None:
        """The warning has come and gone, and the driver has done what he would have done without it."""
        if watch.asleep and watch.fork is not None:
            self._forks.dismiss(watch.fork)
            watch.asleep, watch.fork = False, None

    def _otherwise(self, watch: _Watch, slot: int) -> Outcome:
        """The life of a fork: the intervention does not take place."""
        self._engine.suppress(slot, watch.intervention.span)
        self._engine.act()
        return self._outlook({0: watch})[0]

    def _later(self, watch: _Watch) -> Outcome:
        """The life of a fork made at the end of a run, with an intervention that has not acted until then."""
        if watch.witness.slot is not None:
            self._engine.suppress(watch.witness.slot, watch.intervention.span)
        return self._outlook({0: watch})[0]

    def _outlook(self, watches: dict[int, _Watch]) -> dict[int, Outcome]:
        """Let the world go on until all of these windows have ended."""
        engine, conflicts = self._engine, self._conflicts
        while any(watch.with_ is None for watch in watches.values()) and not engine.session.exhausted:
            engine.observe()
            for crash in engine.crashes:
                conflicts.crash(crash.impact.striker, crash.impact.struck)
            engine.decide()
            slots = [watch.witness.slot for watch in watches.values()]
            conflicts.step(
                engine.time,
                engine.leads,
                engine.paths.crossings,
                engine.wrecks.wrecked,
                engine.fleet.equipped,
                among=np.array(sorted({slot for slot in slots if slot is not None}), np.int64),
            )
            for watch in watches.values():
                if watch.with_ is None:
                    watch.look()
            engine.act()
        return {number: watch.with_ or watch.witness.outcome() for number, watch in watches.items()}

    def _settle(self, answers: dict[int, Answer]) -> None:
        """Give the verdicts for which all is known."""
        for number, watch in list(self._watches.items()):
            if watch.fork in answers:
                watch.without = answers[watch.fork]
            if watch.with_ is None or watch.row is not None:
                continue
            if watch.fork is None and watch.without is None:  # it never acted: both worlds are one
                watch.without = Answer(watch.with_)
            if watch.without is None:
                continue
            watch.row = _columns(watch, watch.with_, watch.without)
            if not self._sampled:
                watch.intervention.judge(watch.row)
                del self._watches[number]


def _columns(watch: _Watch, with_: Outcome, without: Answer) -> dict[str, Any]:
    """Columns of table `interventions`."""
    if without.failure:
        return {"verdict": "unknown", "verdict_reason": without.failure, **_world("with", with_)}
    return {
        "verdict": verdict(with_, without.value),
        "verdict_window_s": watch.window,
        "acted_by": watch.acted_by,
        "acted_s": watch.acted,
        **_world("with", with_),
        **_world("without", without.value),
    }


def _world(name: str, outcome: Outcome) -> dict[str, Any]:
    hit = outcome.hardest
    values = {
        "crash": hit is not None,
        "impact_speed_mps": hit.impact_speed if hit else None,
        "delta_v_mps": hit.delta_v if hit else None,
        "serious_risk": hit.serious_risk if hit else None,
        "near_crash": outcome.near_crash and hit is None,
        "min_gap_m": outcome.min_gap if isfinite(outcome.min_gap) else None,
        "pet_s": outcome.pet if isfinite(outcome.pet) else None,
        "follower_decel_mps2": outcome.follower_decel,
    }
    return {f"{name}_{what}": value for what, value in values.items()}
