"""A run once more: what `simulate.run` needs for it, from its row in table `runs`."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from aeb_sumo import scenarios, strategies
from aeb_sumo.drivers import profile
from aeb_sumo.equipment import Equipment, equipment
from aeb_sumo.parameters import parse
from aeb_sumo.results.command import arguments
from aeb_sumo.scenarios import Scenario

__all__ = ["Settings", "settings"]


@dataclass(frozen=True, kw_only=True)
class Settings:
    """What a run was made of, as `aeb_sumo.simulate.run` takes it.

    Attributes:
        scenario: what is simulated.
        equip: who has which AEB.
        seed: of SUMO and of the drivers.
        duration: [s].
        step_length: [s].
        blockage: how long wrecks stand [s].
    """

    scenario: Scenario
    equip: Equipment
    seed: int
    duration: float
    step_length: float
    blockage: float


def settings(run: Mapping[str, Any]) -> Settings:
    """What a row of `runs` is of; it repeats the run as its command line (`results.command`) does.

    Files are looked for where the row says; a relative path counts from the present folder.

    Args:
        run: the row, columns as in `TABLES["runs"]`.

    Raises:
        InputError: scenario, driver profile or system are not there any more, or had only been made in Python.
    """
    words = arguments(run)[1:]  # without `run`
    name = None if words[0].startswith("--") else words.pop(0)
    told: dict[str, str] = {}
    assignments = []
    for option, value in zip(words[::2], words[1::2], strict=True):
        if option == "--set":
            assignments.append(value)
        else:
            told[option] = value
    base = scenarios.from_sumocfg(told["--sumocfg"]) if name is None else scenarios.load(name)
    numbers = {key: float(told[key]) for key in ("--demand", "--ebike-share", "--mu") if key in told}
    return Settings(
        scenario=base.varied(
            demand=numbers.get("--demand"),
            ebike_share=numbers.get("--ebike-share"),
            weather=told.get("--weather"),
            mu=numbers.get("--mu"),
            drivers=profile.load(told["--drivers"]) if "--drivers" in told else None,
        ),
        equip=_equipment(told, parse(tuple(assignments))),
        seed=int(told["--seed"]),
        duration=float(told["--duration"]),
        step_length=float(told["--step-length"]),
        blockage=float(told["--blockage"]),
    )


def _equipment(told: Mapping[str, str], parameters: Mapping[str, Any]) -> Equipment:
    if "--equip" in told:
        return Equipment.parse(told["--equip"], parameters)
    share = told.get("--penetration")
    return equipment(
        strategies.load(told["--strategy"], parameters),
        sensing=told.get("--sensing"),
        penetration=None if share is None else float(share),
    )
