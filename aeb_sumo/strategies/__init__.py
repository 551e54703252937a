"""AEB strategies: from what a vehicle knows to what it demands. One published system, one file.

A module of this package that defines `STRATEGY`, a class with the interface of `base.Strategy`, is found by itself;
one from elsewhere comes through the entry-point group `aeb_sumo.strategies`.
"""

from aeb_sumo.registry import find, registered
from aeb_sumo.strategies.base import Strategy

__all__ = ["load", "names"]


def names() -> tuple[str, ...]:
    """Names of all strategies, sorted."""
    return tuple(registered(__name__, "STRATEGY"))


def load(name: str) -> Strategy:
    """A strategy with its published (or documented) parameters.

    Raises:
        InputError: there is no strategy of that name.
    """
    strategy: Strategy = find(__name__, "STRATEGY", "strategy", name)()
    return strategy
