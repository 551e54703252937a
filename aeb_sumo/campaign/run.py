"""What a worker does: simulates one run into the folder of its campaign."""

from collections.abc import Callable, Mapping
from typing import Any

from aeb_sumo import scenarios, strategies
from aeb_sumo.campaign.identity import Fitted, code, content, differences, known
from aeb_sumo.campaign.settings import Settings
from aeb_sumo.errors import InputError
from aeb_sumo.simulate import run

__all__ = ["NotTheSameError", "get_ready", "prepare", "simulate"]


class NotTheSameError(Exception):
    """Here are other files, or another program, than where the campaign was started."""


def get_ready() -> None:
    """Import all that runs are made with, and only then look at the code: what is edited later is another program."""
    strategies.names()
    scenarios.names()
    code()


def prepare(job: Mapping[str, Any]) -> None:
    """Calculate what the systems of a run have calculated once per process, such as control surfaces.

    Those from outside are left alone: what they remember shall not depend on the runs before.

    Raises:
        Exception: whatever keeps them from being made; `simulate` says what.
    """
    for system in Settings.of(job["settings"]).carried.make().systems:
        if type(system.strategy).__module__.startswith("aeb_sumo."):
            system.strategy.init(1)


def simulate(job: Mapping[str, Any], stop: Callable[[], bool]) -> tuple[str, str]:
    """Simulate a run and put its tables where they belong.

    Args:
        job: from `runner.payload`.
        stop: asked after every step.

    Returns:
        Outcome and reason, as in table `runs`.

    Raises:
        NotTheSameError: the run would not be what its id says.
        InputError: SUMO refuses the scenario, or the tables cannot be written.
    """
    settings = Settings.of(job["settings"])
    try:
        world, carried = known(settings.world.make()), Fitted(settings.carried.make())
    except InputError as error:  # it was none where the campaign was started
        raise NotTheSameError(str(error)) from None
    if differing := differences(job["content"], content(world, carried, settings)):
        raise NotTheSameError(", ".join(differing))
    # The cores are taken by runs: one fork beside each.
    done = run(
        world.scenario, equip=carried.equipment, seed=settings.seed, duration=settings.duration_s,
        step_length=settings.step_length_s, blockage=settings.blockage_s, interval=settings.interval_s,
        verdicts=settings.verdicts, forks=1, stop=stop, out=job["out"], run_id=job["run_id"],
    )  # fmt: skip
    outcome, reason = done.tables["runs"].select(["outcome", "reason"]).to_pylist()[0].values()
    return outcome, reason
