"""Replay: an event of a run as a small animation, as it happened and as it would have otherwise, side by side."""

from pathlib import Path

from aeb_sumo.equipment import Equipment, Share
from aeb_sumo.errors import InputError
from aeb_sumo.repeat import settings
from aeb_sumo.replay.check import check
from aeb_sumo.replay.director import Director
from aeb_sumo.replay.event import Event, find
from aeb_sumo.replay.page import page
from aeb_sumo.replay.take import Take
from aeb_sumo.simulate import run

__all__ = ["film", "find", "page", "replay"]

_LONGEST = 120.0  # s of film before or after an event, our assumption: pages shall stay small


def replay(folder: Path, text: str, *, run_id: str | None = None, before: float = 5.0, after: float = 6.0) -> str:
    """An event of a folder of results as an HTML page that needs nothing else.

    Args:
        folder: with the tables.
        text: `crash:ID` or `intervention:ID`.
        run_id: the run; None if only one of the folder has such an event.
        before: as for `film` [s].
        after: as for `film` [s].

    Raises:
        InputError: the input is bad, or the run does not come out as the tables have it.
    """
    return page(film(find(folder, text, run_id), before=before, after=after))


def film(event: Event, *, before: float = 5.0, after: float = 6.0) -> Take:
    """Simulate the run of an event again, until it is over, and film it in both worlds.

    Args:
        event: which.
        before: film before the event [s], our assumption; at least a second before the worlds part.
        after: film after it [s], our assumption; at least for as long as a verdict looks.

    Raises:
        InputError: seconds are out of range, the run cannot be repeated, or it does not come out as the tables have it.
    """
    for name, value in (("before", before), ("after", after)):
        if not 0 <= value <= _LONGEST:
            raise InputError(f"seconds {name} the event must lie within 0..{_LONGEST:g}, not {value:g}")
    made = settings(event.run)
    director = Director(event, mu=made.scenario.mu, before=before, after=after)
    try:
        again = run(
            made.scenario,
            equip=made.equip if event.intervention is not None else _with(made.equip, event),
            seed=made.seed,
            duration=director.end - float(event.run["begin_s"]) + made.step_length,
            step_length=made.step_length,
            blockage=made.blockage,
            trace=director,
            stop=lambda: director.done,
        )
        check(event, again)
        factual, answer = director.worlds()
    finally:
        director.end_forks()
    return Take(event=event, forked=director.forking, factual=factual, other=answer.value, reason=answer.failure)


def _with(carried: Equipment, event: Event) -> Equipment:
    """Who carries what, and besides a system that nobody has yet."""
    if event.system.name in {system.name for system in carried.systems}:
        return carried
    return Equipment((*carried.shares, Share(system=event.system, share=0.0)))
