"""Staged braking, as measured on car N (radar and camera) of source 002: jab, level one, level two.

A test report of two cars in CCRm 40/20 at 100 % and 50 % overlap (shared/seeds.md 3). It prints what the cars did and
nothing of their algorithms: the triggers below are calibrated to its Table 2 and section 3.1.
"""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from aeb_sumo.criticality import ttc
from aeb_sumo.errors import InputError
from aeb_sumo.parameters import within
from aeb_sumo.soa import Floats, Ints
from aeb_sumo.strategies.base import Demand, Gaze, Percept, Phase, Strategy
from aeb_sumo.vehicle.brake import BrakeParams

__all__ = ["STRATEGY", "Staged", "StagedState"]


@dataclass(frozen=True)
class StagedState:
    """Memory, (n,) each: `Phase`, time since braking began [s], and whether the jab is left out."""

    phase: Ints
    braking_for: Floats
    late: Floats


@dataclass(frozen=True, kw_only=True)
class Staged(Strategy):
    """Car N with its parameters.

    Attributes:
        warn_ttc: a warning from this TTC on [s], our assumption: calibrated to Table 2 (2.62 s at 100 % overlap).
        brake_ttc: braking from this TTC on [s], from another source (seeds F5: the printed stages have to start 4.83 m
            before contact), less what the brake takes to answer.
        late_ttc: a warning that comes later than this TTC is followed by level one at once, as on car M (3.1) [s]; 2.0
            is printed as the least that a warning should leave (2.2).
        jab: deceleration that wakes the driver [m/s2], printed (1.92).
        jab_time: its length [s], from another source (seeds F5: 0.2).
        level_one: [m/s2], printed (4.25).
        level_one_time: [s], printed (0.43).
        level_two: [m/s2], printed (9.54).
        reserve: level two comes at once, and goes beyond its figure, when that takes to keep this gap [m]; 0.6 is
            printed as the least that should remain (2.2), the rule is our assumption: car M brakes harder than level
            two "because the gap was too small" (3.1).
        brake: build-up of 25 m/s3, from another source (seeds F5).
    """

    name: ClassVar[str] = "staged"
    source: ClassVar[str] = "shared/seeds 002: AEB tests of cars M and N in CCRm 40/20 at 100 % and 50 % overlap"
    sensing: ClassVar[str] = "fusion"
    gaze: ClassVar[Gaze] = Gaze.LEAD  # the source treats CCRm alone (seeds 3.1)

    warn_ttc: float = within(2.62, 0.1, 10.0)
    brake_ttc: float = within(0.88, 0.1, 10.0)
    late_ttc: float = within(2.0, 0.0, 10.0)
    jab: float = within(1.92, 0.0, 12.0)
    jab_time: float = within(0.2, 0.0, 5.0)
    level_one: float = within(4.25, 0.0, 12.0)
    level_one_time: float = within(0.43, 0.0, 5.0)
    level_two: float = within(9.54, 0.0, 12.0)
    reserve: float = within(0.6, 0.0, 10.0)
    brake: BrakeParams = field(
        default_factory=lambda: BrakeParams(dead_time=0.0, lag=0.0, build_up=25.0, release=25.0, open_loop=True)
    )

    def __post_init__(self) -> None:
        """Raises `InputError` for a parameter out of range."""
        super().__post_init__()
        if self.warn_ttc < self.brake_ttc:
            raise InputError(f"{type(self).__name__}.warn_ttc must not be below brake_ttc ({self.brake_ttc:g})")

    def longest_ttc(self, mu: float) -> float:  # noqa: ARG002
        """See `Strategy.longest_ttc`."""
        return self.warn_ttc

    def init(self, n: int) -> StagedState:
        """See `Strategy.init`."""
        return StagedState(np.zeros(n, np.int64), np.zeros(n), np.zeros(n))

    def step(self, state: StagedState, percept: Percept, dt: float) -> tuple[StagedState, Demand]:
        """See `Strategy.step`."""
        closing = percept.ego_speed - percept.target_speed
        time = ttc(gap=percept.gap, closing_speed=closing)
        alive = percept.valid & (percept.ego_speed > 0) & (closing > 0)
        warning = alive & (time <= self.warn_ttc)
        starts = warning & (state.phase == Phase.NONE)
        late = np.where(starts, time < self.late_ttc, state.late > 0) & warning
        was_braking = state.phase >= Phase.PARTIAL_BRAKE
        braking = alive & (was_braking | (warning & ((time <= self.brake_ttc) | late)))
        # The clock of the stages: without the jab it starts behind it.
        clock = np.where(was_braking, state.braking_for + dt, np.where(late, self.jab_time, 0.0))
        needed = closing**2 / (2 * np.maximum(percept.gap - self.reserve, 0.05))
        jabbing = clock < self.jab_time - dt / 2
        due = (clock >= self.jab_time + self.level_one_time - dt / 2) | (needed >= self.level_two)
        full = braking & (due | (state.phase == Phase.FULL_BRAKE))
        level = np.where(jabbing, self.jab, self.level_one)
        decel = np.where(full, np.maximum(self.level_two, np.minimum(needed, 12.0)), np.where(braking, level, 0.0))
        phase = np.select([full, braking, warning], [Phase.FULL_BRAKE, Phase.PARTIAL_BRAKE, Phase.WARN], Phase.NONE)
        phase = phase.astype(np.int64)
        return StagedState(phase, np.where(braking, clock, 0.0), late.astype(float)), Demand(phase=phase, decel=decel)


STRATEGY = Staged
