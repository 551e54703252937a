"""No AEB: the baseline of every comparison."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from aeb_sumo.soa import Bools
from aeb_sumo.strategies.base import Demand, Gaze, Percept, Strategy

__all__ = ["STRATEGY"]


@dataclass(frozen=True)
class Nothing:
    """State of a system that remembers nothing."""

    unused: Bools


@dataclass(frozen=True, kw_only=True)
class NoAeb(Strategy):
    """Never warns and never brakes."""

    name: ClassVar[str] = "none"
    gaze: ClassVar[Gaze] = Gaze.LEAD
    source: ClassVar[str] = "-"

    def init(self, n: int) -> Nothing:
        """See `Strategy.init`."""
        return Nothing(np.zeros(n, np.bool_))

    def step(self, state: Nothing, percept: Percept, dt: float) -> tuple[Nothing, Demand]:  # noqa: ARG002
        """See `Strategy.step`."""
        return state, Demand.nothing(len(percept.gap))


STRATEGY = NoAeb
