"""The "traditional" rival of Lin et al. 2021: the same law with a friction coefficient that never changes."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from aeb_sumo.parameters import within
from aeb_sumo.soa import Floats
from aeb_sumo.strategies.base import Percept
from aeb_sumo.strategies.lin2021 import Lin2021
from aeb_sumo.vehicle.brake import BrakeParams

__all__ = ["STRATEGY", "Lin2021Fixed"]


@dataclass(frozen=True, kw_only=True)
class Lin2021Fixed(Lin2021):
    """The system with its parameters.

    Attributes:
        mu: friction coefficient assumed; the paper says "fixed" (3.1) and not at what: 0.8, from another source (seeds
            A15: it gives the printed TTC of 1.0 s).
        brake: a dead time of 0.14 s, from another source (seeds 2.4), on every road.
    """

    name: ClassVar[str] = "lin2021_fixed"
    estimates_friction: ClassVar[bool] = False

    mu: float = within(0.8, 0.05, 1.5)
    brake: BrakeParams = field(
        default_factory=lambda: BrakeParams(dead_time=0.14, lag=0.0, build_up=np.inf, release=np.inf, open_loop=True)
    )

    def friction(self, percept: Percept) -> Floats:
        """See `Lin2021.friction`."""
        return np.full(len(percept.gap), self.mu)


STRATEGY = Lin2021Fixed
