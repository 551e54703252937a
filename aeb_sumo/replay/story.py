"""What a replay says in words."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from aeb_sumo.replay.director import World
from aeb_sumo.replay.film import Contact
from aeb_sumo.replay.take import Take
from aeb_sumo.results import VERDICTS
from aeb_sumo.results.command import arguments, shell

__all__ = ["Story", "story"]

_KMH = 3.6
_NO_BREAK = "\N{NO-BREAK SPACE}"  # between a number and its unit
_TOLD = 3  # crashes that are told one by one
_PHASES = {"warn": "warns", "partial_brake": "brakes partially", "full_brake": "brakes fully"}


@dataclass(frozen=True)
class Story:
    """What a page says.

    Attributes:
        title: what happened.
        subtitle: where and when.
        worlds: name, and what came of it, of each world.
        judged: what the verdict is on.
        verdict, meaning: one word, and what it means; empty where nothing can be said.
        note: what the other world is, or why there is none.
        event: what t = 0 is.
        facts: name and value.
        command: repeats the run.
    """

    title: str
    subtitle: str
    worlds: tuple[tuple[str, str], ...]
    judged: str
    verdict: str
    meaning: str
    note: str
    event: str
    facts: tuple[tuple[str, str], ...]
    command: str


def story(take: Take) -> Story:
    """The words of a replay."""
    event, run = take.event, take.event.run
    given, meaning = _verdict(take)
    names = ["As it happened", _other_name(take)]
    return Story(
        title=_title(take),
        subtitle=f"{event.kind} {event.number} of run {run['run_id']}, at {event.instant:.2f} s of simulated time",
        worlds=tuple((name, _outcome(take, world)) for name, world in zip(names, take.worlds, strict=False)),
        judged=_judged(take),
        verdict=given,
        meaning=meaning,
        note=_note(take),
        event="the contact" if event.kind == "crash" else "the beginning of the intervention",
        facts=tuple(_facts(take)),
        command=shell(arguments(run)),
    )


def _title(take: Take) -> str:
    row, event = take.event.row, take.event
    if event.kind == "crash":
        return f"{row['striker']} ({row['striker_vclass']}) hits {row['struck']} ({row['struck_vclass']})"
    target = f" for {row['target']} ({row['target_vclass']})" if row["target"] else ""
    return f"{row['strategy']} in {row['vehicle']} {_PHASES[row['phase']]}{target}"


def _judged(take: Take) -> str:
    if take.event.intervention is None:
        return f"Verdict on {take.event.system.name}, had it been there"
    return "Verdict on the intervention" + (f" of {take.event.ego}" if take.event.kind == "crash" else "")


def _verdict(take: Take) -> tuple[str, str]:
    event = take.event
    written = str(event.intervention["verdict"]) if event.intervention is not None else ""
    if written:
        reason = str(event.intervention["verdict_reason"]) if event.intervention is not None else ""
        return written, reason or VERDICTS[written]
    return take.verdict, VERDICTS[take.verdict] if take.verdict else ""


def _other_name(take: Take) -> str:
    if take.event.intervention is not None:
        return "Without the intervention"
    return f"With {take.event.system.name} in {' and '.join(take.other.equipped) if take.other else ''}"


def _note(take: Take) -> str:
    event = take.event
    if take.other is None:
        return f"There is no other world to compare with: {take.reason}."
    if event.intervention is None:
        return (
            f"The other world parts from this one {event.instant - take.parting:.1f} s before the crash: from then on "
            f"the AEB {event.system.name} is in {' and '.join(take.other.equipped)}. Nothing else is changed."
        )
    whose, which = ("it", "this") if event.kind == "intervention" else (f"the intervention of {event.ego}", "that")
    acted, later = str(event.intervention["acted_by"]), take.parting - take.forked
    return (
        f"The other world is a copy of this one, made when {whose} began, in which {which} intervention does not take "
        "place. Nothing else is changed."
        + (f" Until it acts {later:.1f} s later, by its {acted}, the two are the same." if acted else "")
        + (f" It was for {event.other}; the gap is that to {take.partner}." if take.partner != event.other else "")
    )


def _outcome(take: Take, world: World) -> str:
    event = take.event
    behind = {hit.pair for hit in world.outcome.hits}
    contacts = [
        c
        for c in world.film.contacts
        if {c.striker, c.struck} & {event.ego, take.partner} or tuple(sorted((c.striker, c.struck))) in behind
    ]
    if contacts:
        told = " ".join(_hit(c, event.instant) for c in contacts[:_TOLD])
        more = len(contacts) - _TOLD
        return told + (f" {more} more crashes follow." if more > 1 else " One more crash follows." if more == 1 else "")
    gaps = world.film.gap(event.ego, take.partner)[world.film.times >= take.parting]
    least = f" Smallest gap to {take.partner}: {np.nanmin(gaps):.1f}{_NO_BREAK}m." if np.isfinite(gaps).any() else ""
    return f"No crash.{least}"


def _hit(contact: Contact, instant: float) -> str:
    when = f"{contact.time - instant:.1f}".replace("-", "−")
    speed = f"{contact.speed:.1f}~m/s ({contact.speed * _KMH:.0f}~km/h), t~=~{when}~s.".replace("~", _NO_BREAK)
    return f"{contact.striker} hits {contact.struck} at {speed}"


def _facts(take: Take) -> list[tuple[str, str]]:
    event, run, row = take.event, take.event.run, take.event.row
    facts = [("scenario", f"{run['scenario']}, seed {run['seed']}, step {run['step_length_s']:g} s")]
    road = f"friction {run['mu']:g}" + (f", {run['weather']}" if run["weather"] else "")
    facts += [("road", road), ("drivers", str(run["drivers"])), ("AEB in this run", _carried(run))]
    if event.kind == "crash":
        errors = [
            f"{who} {name}: {row[f'{who}_error'].replace('_', ' ') or 'none'}"
            for who, name in (("striker", row["striker"]), ("struck", row["struck"]))
        ]
        facts += [
            ("kind of crash", str(row["kind"]).replace("_", " ") + (", secondary" if row["secondary"] else "")),
            ("impact speed", _speed(row["impact_speed_mps"])),
            ("driver errors", "; ".join(errors)),
        ]
    else:
        facts += [
            ("target", f"{row['target']}, {'crossing' if row['target_kind'] == 'crossing' else 'ahead'}"),
            ("speed at its beginning", _speed(row["speed_mps"])),
            (
                "from / to",
                f"{row['begin_s']:.2f} s / {row['end_s']:.2f} s, ended by {row['ended_by'].replace('_', ' ')}",
            ),
            ("largest braking by the AEB", f"{row['max_decel_mps2']:.1f} m/s²"),
            ("driver error", str(row["driver_error"]).replace("_", " ") or "none"),
        ]
    facts.append(("worlds part", f"at {take.parting:.2f} s" if take.other is not None else "not"))
    facts.append(("made by", f"aeb-sumo {run['aeb_sumo_version']}, SUMO {run['sumo_version']}"))
    return facts


def _carried(run: Mapping[str, Any]) -> str:
    return "none" if run["strategy"] == "none" else f"{run['strategy']} ({run['sensing']})"


def _speed(value: float) -> str:
    return f"{value:.1f} m/s ({value * _KMH:.0f} km/h)"
