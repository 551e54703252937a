"""AEB strategies: from what a vehicle knows to what it demands. One published system, one file.

A module of this package that defines `STRATEGY`, a subclass of `base.Strategy`, is found by itself; one from elsewhere
comes through the entry-point group `aeb_sumo.strategies`.
"""

from collections.abc import Mapping
from typing import Any

from aeb_sumo.parameters import changed
from aeb_sumo.registry import find, registered
from aeb_sumo.strategies.base import Strategy

__all__ = ["load", "names"]


def names() -> tuple[str, ...]:
    """Names of all strategies, sorted."""
    return tuple(registered(__name__, "STRATEGY"))


def load(name: str, parameters: Mapping[str, Any] | None = None) -> Strategy:
    """A strategy with its published (or documented) parameters, or with some of them changed.

    Args:
        name: as in `names()`.
        parameters: field -> value; `brake.lag` reaches into the brake.

    Raises:
        InputError: there is no strategy of that name, or a parameter is unknown, of the wrong type or out of range.
    """
    strategy: Strategy = find(__name__, "STRATEGY", "strategy", name)()
    return changed(strategy, parameters or {})
