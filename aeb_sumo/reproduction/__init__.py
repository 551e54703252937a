"""The published results of every system, run again in SUMO and compared row by row (shared/seeds.md 6).

A module of this package that defines `SYSTEM`, a `system.System`, is found by itself; one from elsewhere comes through
the entry-point group `aeb_sumo.reproduction`.
"""

from aeb_sumo.registry import find, registered
from aeb_sumo.reproduction.rows import Row, Verdict
from aeb_sumo.reproduction.system import Drives, System, run_cases

__all__ = ["Drives", "Row", "System", "Verdict", "load", "names", "run_cases"]


def names() -> tuple[str, ...]:
    """Names of all systems that can be reproduced, sorted."""
    return tuple(registered(__name__, "SYSTEM"))


def load(name: str) -> System:
    """A system by name.

    Raises:
        InputError: there is none of that name.
    """
    system: System = find(__name__, "SYSTEM", "system", name)
    return system
