"""`DIR/campaign.log`: what every run took, a line of JSON each. Only for planning: nothing is lost with it."""

import json
from contextlib import suppress
from dataclasses import asdict

from aeb_sumo.campaign.execute import Outcome
from aeb_sumo.results.place import Place

__all__ = ["NAME", "note", "spent"]

NAME = "campaign.log"


def note(out: str, outcome: Outcome) -> None:
    """Write a line; where nothing can be appended, as at most URLs, there is none."""
    folder = Place.of(out).local
    if folder is not None:
        with suppress(OSError), (folder / NAME).open("a", encoding="utf-8") as file:
            file.write(json.dumps(asdict(outcome)) + "\n")


def spent(out: str) -> dict[str, Outcome]:
    """Run -> how it went, for runs that have a line; the last one counts."""
    folder = Place.of(out).local
    found = {}
    with suppress(OSError):
        for line in (folder / NAME).read_text(encoding="utf-8").splitlines() if folder is not None else ():
            with suppress(ValueError, TypeError):  # cut off in the middle
                outcome = Outcome(**json.loads(line))
                found[outcome.run_id] = outcome
    return found
