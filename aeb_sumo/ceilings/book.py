"""Looks on while a baseline is run again, and forks the world before its crashes."""

from collections.abc import Sequence
from functools import partial
from typing import Any

from aeb_sumo.ceilings.cases import Case, Otherwise, row_of
from aeb_sumo.engine import Engine
from aeb_sumo.verdicts import Hit
from aeb_sumo.verdicts.witness import hit_of
from aeb_sumo.world.fork import Answer, Forks, obstacle

__all__ = ["Book"]

BEFORE = 8.0
"""How long before the crash the world is forked [s], our assumption: longer than any ceiling looks ahead."""

AFTER = 6.0
"""How long after it the fork goes on [s], our assumption: long enough for a driver to take over and drive on."""

NEAR = 3.0
"""From so long before the crash on the system acts on anybody [s], our assumption; before that on those alone whom its
vehicle will crash with. What it would do there about others (brake for a queue, stop for the last e-bike but one) might
well do away with the crash, but because the encounter does not come about."""


class Book:
    """Looks on at the second run, and forks it.

    Args:
        cases: crashes and ceilings.
        forks: where the other worlds live.
    """

    def __init__(self, cases: Sequence[Case], forks: Forks) -> None:
        self.forks = forks
        self._cases = cases
        self._known = {case.pair for case in cases}
        self._forked: dict[int, tuple[int, float]] = {}  # number of the case -> number of its fork, and when [s]
        self._answers: dict[int, Answer] = {}
        self._obstacle = ""
        self._engine: Engine

    def attend(self, world: Engine) -> None:
        """The second run begins."""
        self._engine, self._obstacle = world, obstacle()

    def step(self, time: float) -> None:
        """Fork for the crashes that are near now."""
        for number, case in enumerate(self._cases):
            near = case.equip and time >= case.time - BEFORE and not self._obstacle
            if near and number not in self._forked:
                self._forked[number] = self.forks.split(partial(self._future, case)), time
        self._answers |= self.forks.answers()

    def rows(self, strayed: str) -> list[dict[str, Any]]:
        """Rows of table `ceilings`, all but `run_id`.

        Args:
            strayed: why nothing is known of them; empty if it is.
        """
        if not strayed:
            self._answers |= self.forks.answers(wait=True)
        unknown = Answer(failure=strayed or self._obstacle or "the second run ended before its time")
        rows = []
        for number, case in enumerate(self._cases):
            fork, when = self._forked.get(number, (None, None))
            rows.append(row_of(case, unknown if strayed or fork is None else self._answers[fork], when))
        return rows

    def _future(self, case: Case) -> Otherwise:
        """The life of a fork: the world with the ceiling in it.

        Whom others run into, and so push against the other one of the pair, has not crashed with that one by himself.
        """
        engine, t = self._engine, self._engine.traffic
        waiting, braked = set(case.equip), None
        slots: list[int] = []
        free: set[int] = set()
        new: list[Hit] = []
        pushed = False
        self._equip(case, waiting, slots)
        engine.act()
        while engine.time < case.time + AFTER and not engine.session.exhausted:
            engine.observe()
            for crash in engine.crashes:
                hit = hit_of(crash, t.vclass, own=True)
                if hit.pair == case.pair and not pushed:
                    return Otherwise(braked=braked, own=hit, new=())
                if set(hit.pair) & set(case.equip):
                    pushed |= hit.pair not in case.before
                    if hit.pair not in self._known:
                        new.append(hit)
            self._equip(case, waiting, slots)
            engine.decide()
            if engine.time < case.time - NEAR:
                self._hold_back(case, slots, free)
            if braked is None and any(engine.fleet.decel[slot] > 0 for slot in slots):
                braked = engine.time
            engine.act()
        return Otherwise(braked=braked, own=None, new=tuple(new))

    def _hold_back(self, case: Case, slots: list[int], free: set[int]) -> None:
        """Undo what the systems are about to do about others; who has acted on a foe is `free` from then on."""
        engine = self._engine
        for slot, target in list(engine.acting):
            if slot not in slots or slot in free:
                continue
            if target is not None and engine.traffic.ids[target.slot] in case.foes:
                free.add(slot)
                continue
            engine.motorists.unwarned(slot)
            engine.equip(slot, case.ceiling)

    def _equip(self, case: Case, waiting: set[str], slots: list[int]) -> None:
        """Those on the road get the system."""
        for vehicle in sorted(waiting & self._engine.traffic.slot.keys()):
            waiting.remove(vehicle)
            slots.append(self._engine.traffic.slot[vehicle])
            self._engine.equip(slots[-1], case.ceiling)
