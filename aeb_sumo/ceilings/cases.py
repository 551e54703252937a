"""Crashes of a baseline as cases to be judged: who gets a ceiling's system, and the row that comes of it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from aeb_sumo.verdicts import Hit, Outcome, verdict
from aeb_sumo.world.fork import Answer
from aeb_sumo.world.kinds import VClasses
from aeb_sumo.world.wrecks import pair_of

__all__ = ["Case", "Otherwise", "cases", "row_of"]

_NOBODY = "no motor vehicle whose braking could help"


@dataclass(frozen=True, kw_only=True)
class Case:
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
class Otherwise:
    """What a fork came to: when somebody first braked, the crash of the pair, and new ones of the equipped."""

    braked: float | None
    own: Hit | None
    new: tuple[Hit, ...]


def cases(crashes: pd.DataFrame, systems: Sequence[str]) -> Iterator[Case]:
    """Every crash, once per system.

    Those get it whose braking could help: motor vehicles; of the two in a rear-end crash only the one behind.

    Args:
        crashes: table `crashes` of a run.
        systems: names.
    """
    earlier: list[tuple[str, str]] = []
    for crash in crashes.to_dict("records"):
        who = ("striker",) if crash["kind"] == "rear_end" else ("striker", "struck")
        risk = [r for r in (crash["striker_serious_risk"], crash["struck_serious_risk"]) if pd.notna(r)]
        pair = pair_of(crash["striker"], crash["struck"])
        equip = tuple(crash[one] for one in who if crash[f"{one}_vclass"] in VClasses.DRIVEN)
        before = frozenset(one for one in earlier if set(one) & set(equip))
        earlier.append(pair)
        for name in systems:
            yield Case(
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


def row_of(case: Case, answer: Answer, when: float | None) -> dict[str, Any]:
    """Row of table `ceilings`, all but `run_id`.

    Args:
        case: the crash and the ceiling.
        answer: an `Otherwise`, or why there is none.
        when: the world was forked [s].
    """
    row: dict[str, Any] = {"crash_id": case.crash_id, "ceiling": case.ceiling, "equipped": " ".join(case.equip)}
    row |= {"forked_s": when, "other": "", "reason": "", **_world("without", case.hit)}
    if not case.equip:
        return row | {"outcome": "unchanged", "reason": _NOBODY, **_world("with", case.hit)}
    if answer.failure:
        return row | {"outcome": "unknown", "reason": answer.failure}
    found: Otherwise = answer.value
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
