"""What a run is made of, and the id that follows from it: the same on any machine and path, another if anything is."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from importlib.metadata import PackageNotFoundError, version
from inspect import getsourcefile
from pathlib import Path
from typing import Any

from aeb_sumo.campaign.inputs import (
    digest,
    files,
    of_file,
    options_of,
    seed_of,
    source,
    span_of,
    switches,
    teleport_after,
)
from aeb_sumo.campaign.settings import Settings
from aeb_sumo.equipment import Equipment
from aeb_sumo.scenarios import Scenario

__all__ = ["Fitted", "Known", "code", "content", "differences", "known", "run_id"]

_LONGEST = 200  # bytes of the part that can be read: a file name has 255
_DIGITS = 12  # of the digest in an id; two of a million runs have the same with a probability of 0.2 %


@dataclass(frozen=True, kw_only=True)
class Known:
    """A scenario with what its files say.

    Attributes:
        scenario: what is simulated.
        files: as from `inputs.files`.
        seed: where none is given.
        teleport_after: [s].
        span: simulated time where none is given [s]; None until all vehicles have arrived.
    """

    scenario: Scenario
    files: Mapping[str, str]
    seed: int
    teleport_after: float
    span: float | None

    @cached_property
    def made_of(self) -> dict[str, Any]:
        """What a run depends on of all this."""
        scenario = self.scenario
        return {
            "scenario": Path(scenario.name).stem,
            "files": dict(sorted(self.files.items())),
            "options": switches(scenario),
            "traffic": digest(scenario.vehicles),
            "stretches": digest(repr(scenario.stretches)),
            "variation": scenario.variation,
            "demand": scenario.factor,
            "ebike_share": scenario.demand.ebike_share if scenario.demand else None,
            "weather": scenario.weather,
            "mu": scenario.mu,
            "drivers": digest(repr(replace(scenario.drivers, name=""))),
        }


@dataclass(frozen=True)
class Fitted:
    """Equipment, looked at once for all runs that have it."""

    equipment: Equipment

    @cached_property
    def made_of(self) -> dict[str, Any]:
        """What a run depends on of it."""
        equip = self.equipment
        return {
            "strategy": equip.name,
            "sensing": equip.sensing,
            "penetration": equip.text,
            "parameters": equip.parameters,
            "systems": digest(repr(equip.systems) + _from_outside(equip)),
        }


def known(scenario: Scenario) -> Known:
    """Look into the files of a scenario.

    Raises:
        InputError: one is missing or cannot be read.
    """
    options = options_of(scenario)
    return Known(
        scenario=scenario,
        files=files(scenario.name, options),
        seed=seed_of(scenario, options),
        teleport_after=teleport_after(options),
        span=span_of(scenario, options),
    )


@cache
def code() -> dict[str, str]:
    """What simulates: digest of the program's source files, and the version of SUMO."""
    try:
        sumo = version("libsumo")
    except PackageNotFoundError:  # built by hand
        sumo = "unknown"
    return {"source": source(), "sumo": sumo}


def content(world: Known, carried: Fitted, settings: Settings) -> dict[str, Any]:
    """All that a run depends on, in one form: what is left to a default is written out.

    Args:
        world: what is simulated.
        carried: who has which AEB.
        settings: of which those of the run as a whole are used; the others are in the first two.

    Returns:
        Keys in a fixed order, values that JSON holds; paths are not among them.
    """
    return {
        **world.made_of,
        **carried.made_of,
        "seed": settings.seed,
        "duration_s": settings.duration_s or world.scenario.duration,
        "step_length_s": settings.step_length_s or world.scenario.step_length,
        "blockage_s": settings.blockage_s,
        "interval_s": settings.interval_s,
        "verdicts": settings.verdicts.strip(),
        "code": code(),
    }


def _from_outside(carried: Equipment) -> str:
    """Digests of the files of systems that are not part of this program."""
    types = {type(system.strategy) for system in carried.systems}
    outside = sorted((t for t in types if t.__module__.partition(".")[0] != "aeb_sumo"), key=lambda t: t.__qualname__)
    return "".join(of_file(Path(file)) for t in outside if (file := getsourcefile(t)) is not None)


def run_id(world: Known, carried: Fitted, seed: int, made_of: Mapping[str, Any]) -> str:
    """Id of a run: what a single run would be called, and a digest of its content."""
    scenario = world.scenario
    name = "-".join(filter(None, (Path(scenario.name).stem, scenario.variation)))
    of_content = digest(json.dumps(made_of, sort_keys=True))[:_DIGITS]
    readable = carried.equipment.run_id(name, seed).lstrip("._").encode()[:_LONGEST].decode(errors="ignore")
    return f"{readable}-{of_content}"


def differences(one: Mapping[str, Any], two: Mapping[str, Any]) -> list[str]:
    """What differs between the contents of two runs, as `key (one, two)`."""
    return [
        f"{key} ({_short(one.get(key))} there, {_short(two.get(key))} here)"
        for key in dict.fromkeys((*one, *two))
        if one.get(key) != two.get(key)
    ]


def _short(value: Any) -> str:
    text = json.dumps(value) if isinstance(value, dict | list) else "none" if value is None else str(value) or "nothing"
    return text if len(text) <= 60 else text[:57] + "..."
