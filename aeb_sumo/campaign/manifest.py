"""`DIR/campaign.json`: which campaign a folder belongs to, and what went into the id of every run."""

import json
import os
from collections.abc import Mapping, Sequence
from typing import Any

from aeb_sumo.campaign.expansion import Job
from aeb_sumo.campaign.identity import code, differences
from aeb_sumo.errors import InputError
from aeb_sumo.results import holds_results
from aeb_sumo.results.place import Place

__all__ = ["NAME", "check", "contents", "write"]

NAME = "campaign.json"
_FORMAT = 1


def check(out: str, jobs: Sequence[Job]) -> None:
    """Check that a folder is new, or holds this campaign: some runs may have been added to it, none taken away.

    Raises:
        InputError: it belongs to another campaign, or holds results of something else.
    """
    old = contents(out)
    if old is None:
        if holds_results(out):
            raise InputError(f"--out {out} holds results that are of no campaign; name a new or empty folder")
        return
    new = {job.run_id: job.content for job in jobs}
    gone = next((run for run in old if run not in new), None)
    if gone is not None:
        nearest = min((differences(old[gone], made_of) for made_of in new.values()), key=len)
        raise InputError(
            f"--out {out} belongs to another campaign: its run {gone} is none of these; the nearest differs in "
            f"{', '.join(nearest)}; name a new folder, or only add to the factors"
        )


def contents(out: str) -> dict[str, Mapping[str, Any]] | None:
    """Id -> content of all runs of the campaign that a folder belongs to; None if it belongs to none.

    Raises:
        InputError: it cannot be read.
    """
    place = Place.of(out)
    try:
        text = place.local.joinpath(NAME).read_bytes() if place.local else place.fs.cat_file(place.path("") + NAME)
    except (FileNotFoundError, NotADirectoryError):
        return None
    except Exception as error:  # whatever the package of a file system raises
        raise InputError(f"cannot read {out}/{NAME}: {getattr(error, 'strerror', None) or error}") from None
    try:
        found = json.loads(text)
        runs: dict[str, Mapping[str, Any]] = found["runs"]
        if found["format"] != _FORMAT or not all(isinstance(made_of, dict) for made_of in runs.values()):
            raise ValueError
    except (ValueError, KeyError, TypeError, AttributeError):
        raise InputError(f"{out}/{NAME} cannot be read: it is damaged, or of another version of this program") from None
    return runs


def write(out: str, name: str, jobs: Sequence[Job]) -> None:
    """Write down whose folder it is, as a whole or not at all.

    Args:
        out: folder or URL, which exists.
        name: of the campaign.
        jobs: all of its runs.

    Raises:
        InputError: it cannot be written.
    """
    head = {"format": _FORMAT, "name": name, "code": code()}
    runs = ",\n".join(f"  {json.dumps(job.run_id)}: {json.dumps(job.content)}" for job in jobs)
    text = f'{json.dumps(head)[:-1]}, "runs": {{\n{runs}\n}}}}\n'.encode()
    place = Place.of(out)
    try:
        if place.local is None:
            place.fs.makedirs(place.path("").rstrip("/"), exist_ok=True)
            place.fs.pipe_file(place.path("") + NAME, text)
            return
        partial = place.local / f".{NAME}.partial"
        with partial.open("wb") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        partial.replace(place.local / NAME)
    except Exception as error:  # whatever the package of a file system raises
        raise InputError(f"cannot write {out}/{NAME}: {getattr(error, 'strerror', None) or error}") from None
