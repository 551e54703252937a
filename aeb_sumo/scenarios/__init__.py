"""Scenarios: what is simulated. One file each, or a user's own .sumocfg.

A module of this package that defines `SCENARIO`, a `base.Scenario`, is found by itself; one from elsewhere comes
through the entry-point group `aeb_sumo.scenarios`.
"""

from aeb_sumo.registry import find, registered
from aeb_sumo.scenarios.base import Scenario
from aeb_sumo.scenarios.sumocfg import from_sumocfg

__all__ = ["Scenario", "from_sumocfg", "load", "names"]


def names() -> tuple[str, ...]:
    """Names of all scenarios, sorted."""
    return tuple(registered(__name__, "SCENARIO"))


def load(name: str) -> Scenario:
    """A scenario by name.

    Raises:
        InputError: there is no scenario of that name.
    """
    scenario: Scenario = find(__name__, "SCENARIO", "scenario", name)
    return scenario
