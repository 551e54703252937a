"""Ceilings: would perfect braking, or a careful driver, have avoided the crashes of a baseline?

Runs are deterministic. So the baseline is run again, and some seconds before each of its crashes, which are known now,
the world is forked once per ceiling: in the fork the vehicles of the crash whose braking could help have the ceiling's
system, and nothing else is different.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import pandas as pd
import pyarrow as pa

from aeb_sumo.engine import Engine
from aeb_sumo.equipment import Equipment, Share, System
from aeb_sumo.errors import InputError
from aeb_sumo.ledger.severity import risks
from aeb_sumo.results import TABLES, Results
from aeb_sumo.scenarios import Scenario
from aeb_sumo.simulate import Progress, run
from aeb_sumo.verdicts import Hit, Outcome, verdict
from aeb_sumo.world.fork import Answer, Forks, obstacle
from aeb_sumo.world.observe import VClasses
from aeb_sumo.world.wrecks import Crash

__all__ = ["CEILINGS", "ceilings"]

CEILINGS = ("perfect", "careful")
"""Strategies that are ceilings."""

BEFORE = 8.0
"""How long before the crash the world is forked [s], our assumption: longer than any ceiling looks ahead."""

AFTER = 6.0
"""How long after it the fork goes on [s], our assumption: long enough for a driver to take over and drive on."""

NEAR = 3.0
"""From so long before the crash on the system acts on anybody [s], our assumption; before that on those alone whom its
vehicle will crash with. What it would do there about others (brake for a queue, stop for the last e-bike but one) might
well do away with the crash, but because the encounter does not come about."""

_NOBODY = "no motor vehicle whose braking could help"


@dataclass(frozen=True, kw_only=True)
class _Case:
    """A crash of the baseline and a ceiling.

    Attributes:
        crash_id, time: of the crash [s].
        ceiling: name of its system.
        pair: ids of the two, in alphabetical order.
        equip: ids of those who get the system.
        hit: the crash as it was.
        before: other pairs with one of them in it that had crashed before.
    """

    crash_id: int
    time: float
    ceiling: str
    pair: tuple[str, str]
    equip: tuple[str, ...]
    hit: Hit
    before: frozenset[tuple[str, str]]

    @property
    def foes(self) -> frozenset[str]:
        """Ids of all whom they crash with until then, themselves among them."""
        return frozenset(self.pair).union(*self.before)


@dataclass(frozen=True, kw_only=True)
class _Otherwise:
    """What a fork came to: when somebody first braked, the crash of the pair, and new ones of the equipped."""

    braked: float | None
    own: Hit | None
    new: tuple[Hit, ...]


def ceilings(
    scenario: Scenario,
    baseline: Results,
    *,
    beside: Equipment | None = None,
    forks: Forks | None = None,
    progress: Callable[[Progress], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> Results:
    """The tables of a baseline, with table `ceilings` filled in; all others are the same.

    Args:
        scenario: what was simulated, varied as it was then.
        baseline: one run of it without AEB.
        beside: AEBs that are put in the place of the ceilings as well, to compare; shares do not matter.
        forks: where the other worlds live; None for as many at a time as there are free cores.
        progress: called after every step of the second run, which ends with the last crash.
        stop: asked after every step; True ends it: what is not known then is unknown.

    Raises:
        InputError: it is not one run, not of this scenario, or not without AEB.
    """
    runs = baseline.runs
    if len(runs) != 1:
        raise InputError(f"ceilings are those of one run, not of {len(runs)}")
    of = runs.iloc[0]
    if of["strategy"] != "none":
        raise InputError(f"ceilings are those of a baseline, strategy none, not {of['strategy']}")
    if of["scenario"] != scenario.name:
        raise InputError(f"the baseline is one of scenario {of['scenario']}, not {scenario.name}")
    crashes = baseline.crashes
    rows: list[dict[str, Any]] = []
    if len(crashes):
        systems = {s.name: s for s in (*(beside.systems if beside else ()), *(System.of(name) for name in CEILINGS))}
        book = _Book(
            list(_cases(crashes, [*CEILINGS, *sorted(systems.keys() - CEILINGS)])), Forks() if forks is None else forks
        )
        step, begin = float(of["step_length_s"]), float(of["begin_s"])
        try:
            again = run(
                scenario,
                equip=Equipment(tuple(Share(system=system, share=0.0) for system in systems.values())),
                seed=int(of["seed"]),
                duration=float(crashes["time_s"].max()) + step - begin,
                step_length=step,
                blockage=float(of["blockage_s"]),
                trace=book,
                progress=progress,
                stop=stop,
            )
            rows = book.rows(_strayed(crashes, again))
        finally:
            book.forks.end()
    table = pa.Table.from_pylist([{"run_id": of["run_id"], **row} for row in rows], schema=TABLES["ceilings"].arrow())
    return Results(baseline.tables | {"ceilings": table})


def _cases(crashes: pd.DataFrame, systems: Sequence[str]) -> Iterator[_Case]:
    earlier: list[tuple[str, str]] = []
    for crash in crashes.to_dict("records"):
        who = ("striker",) if crash["kind"] == "rear_end" else ("striker", "struck")
        risk = [r for r in (crash["striker_serious_risk"], crash["struck_serious_risk"]) if pd.notna(r)]
        pair = _pair(crash["striker"], crash["struck"])
        equip = tuple(crash[one] for one in who if crash[f"{one}_vclass"] in VClasses.DRIVEN)
        before = frozenset(one for one in earlier if set(one) & set(equip))
        earlier.append(pair)
        for name in systems:
            yield _Case(
                crash_id=int(crash["crash_id"]),
                time=float(crash["time_s"]),
                ceiling=name,
                pair=pair,
                equip=equip,
                before=before,
                hit=Hit(
                    pair=pair,
                    own=True,
                    impact_speed=crash["impact_speed_mps"],
                    delta_v=max(crash["striker_delta_v_mps"], crash["struck_delta_v_mps"]),
                    serious_risk=sum(risk) if risk else None,
                ),
            )


def _strayed(crashes: pd.DataFrame, again: Results) -> str:
    """Why the second run says nothing of the first; empty if its crashes are the same."""
    outcome, reason = again.runs[["outcome", "reason"]].iloc[0]
    if outcome != "completed":
        return f"the second run {'was' if outcome == 'interrupted' else 'has'} {outcome} {reason}".rstrip()
    labels = ["run_id", "sumo_reported"]  # SUMO may report a crash later than it happens
    if not again.crashes.drop(columns=labels).equals(crashes.drop(columns=labels)):
        return "the second run had other crashes than the first"
    return ""


class _Book:
    """Looks on at the second run, and forks it.

    Args:
        cases: crashes and ceilings.
        forks: where the other worlds live.
    """

    def __init__(self, cases: Sequence[_Case], forks: Forks) -> None:
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
            rows.append(_row(case, unknown if strayed or fork is None else self._answers[fork], when))
        return rows

    def _future(self, case: _Case) -> _Otherwise:
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
                hit = _hit(crash, t.vclass)
                if hit.pair == case.pair and not pushed:
                    return _Otherwise(braked=braked, own=hit, new=())
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
        return _Otherwise(braked=braked, own=None, new=tuple(new))

    def _hold_back(self, case: _Case, slots: list[int], free: set[int]) -> None:
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

    def _equip(self, case: _Case, waiting: set[str], slots: list[int]) -> None:
        """Those on the road get the system."""
        for vehicle in sorted(waiting & self._engine.traffic.slot.keys()):
            waiting.remove(vehicle)
            slots.append(self._engine.traffic.slot[vehicle])
            self._engine.equip(slots[-1], case.ceiling)


def _hit(crash: Crash, vclass: list[str]) -> Hit:
    hit = crash.impact
    risk = [r for name, r in risks(hit, crash.kind, vclass).items() if r is not None and name.endswith("serious_risk")]
    return Hit(
        pair=_pair(crash.striker, crash.struck),
        own=True,
        impact_speed=hit.impact_speed,
        delta_v=max(hit.striker_delta_v, hit.struck_delta_v),
        serious_risk=sum(risk) if risk else None,
    )


def _row(case: _Case, answer: Answer, when: float | None) -> dict[str, Any]:
    row: dict[str, Any] = {"crash_id": case.crash_id, "ceiling": case.ceiling, "equipped": " ".join(case.equip)}
    row |= {"forked_s": when, "other": "", "reason": "", **_world("without", case.hit)}
    if not case.equip:
        return row | {"outcome": "unchanged", "reason": _NOBODY, **_world("with", case.hit)}
    if answer.failure:
        return row | {"outcome": "unknown", "reason": answer.failure}
    found: _Otherwise = answer.value
    row["braked_s"] = found.braked
    if found.own is None and found.new:
        worst = max(found.new, key=lambda hit: hit.impact_speed)
        (other,) = set(worst.pair) - set(case.equip) or {worst.pair[1]}
        return row | {"outcome": "other", "other": other, **_world("with", worst)}
    hits = (found.own,) if found.own else ()
    return row | {"outcome": verdict(Outcome(hits=hits), Outcome(hits=(case.hit,))), **_world("with", found.own)}


def _world(name: str, hit: Hit | None) -> dict[str, Any]:
    return {
        f"{name}_impact_speed_mps": hit.impact_speed if hit else None,
        f"{name}_delta_v_mps": hit.delta_v if hit else None,
        f"{name}_serious_risk": hit.serious_risk if hit else None,
    }


def _pair(one: str, other: str) -> tuple[str, str]:
    return (one, other) if one <= other else (other, one)
