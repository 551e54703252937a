"""Staged braking of car M (radar only) of source 002: no jab, and level one at once after a late warning."""

from dataclasses import dataclass
from typing import ClassVar

from aeb_sumo.parameters import within
from aeb_sumo.strategies.staged import Staged

__all__ = ["STRATEGY", "StagedM"]


@dataclass(frozen=True, kw_only=True)
class StagedM(Staged):
    """Car M with its parameters.

    Attributes:
        warn_ttc, brake_ttc: [s], our assumption: calibrated to Table 2 at 100 % overlap (2.56 s and 0.97 m).
        jab_time: no jab is printed for this car [s].
        level_one: [m/s2], printed (4.34, at 50 % overlap).
        level_two: [m/s2], our assumption: the mean of Table 2 at 100 % overlap (9.50).
    """

    name: ClassVar[str] = "staged_m"
    sensing: ClassVar[str] = "radar"

    warn_ttc: float = within(2.555, 0.1, 10.0)
    brake_ttc: float = within(0.755, 0.1, 10.0)
    jab_time: float = within(0.0, 0.0, 5.0)
    level_one: float = within(4.34, 0.0, 12.0)
    level_two: float = within(9.50, 0.0, 12.0)


STRATEGY = StagedM
