"""Yan et al. 2025: braking for an oncoming e-bike in a left turn, by a virtual lane and the time to reach it.

Yan L., Wu Z., Lin S. et al.: Research on AEB Performance Improvement Method of Electric Two-Wheelers in Accident Scene.
Automotive Engineer 2025(4), 29-35. Equation numbers below are this paper's; "seeds" is shared/seeds.md, section 4 and
A21 ... A25. The paper calls its scene accident type 321; what it describes and draws is 221 (A21).
"""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from aeb_sumo.errors import InputError
from aeb_sumo.parameters import within
from aeb_sumo.soa import Bools, Floats, Ints
from aeb_sumo.strategies.base import Demand, Gaze, Percept, Phase, Strategy
from aeb_sumo.units import KMH
from aeb_sumo.vehicle.brake import BrakeParams

__all__ = ["STRATEGY", "Yan2025", "Yan2025State"]

_RULES = ("and", "lane_entry")


@dataclass(frozen=True)
class Yan2025State:
    """Memory: (n,) `Phase` of the last step, and the deceleration demanded in it [m/s2]."""

    phase: Ints
    decel: Floats


@dataclass(frozen=True, kw_only=True)
class Yan2025(Strategy):
    """The system with its parameters.

    Attributes:
        rule: when time is up. `and`, as printed: the target will be in the virtual lane, and will be there within the
            time. `lane_entry`: it enters the lane, taken with its full width on either side, within the time; only
            this one can give the printed Table 2 (proof in seeds 4.4, A23). It brakes for what the first would, too.
        lane: width of the virtual lane [m], printed (3.8).
        warn_ttc: [s], printed (1.2).
        brake_ttc: [s], printed (1.0).
        horizon: `lane_entry` looks no farther ahead than this dt1 [s], our assumption: without a limit it would brake
            for whoever drives beside the lane, however far away.
        decel: for two-wheelers and pedestrians [m/s2], printed (9).
        decel_slow, decel_medium: for vehicles below `slow` and below `fast` [m/s2], printed (3 and 6; above: `decel`).
        slow, fast: closing speeds that divide the levels [m/s]; "by relative speed" is printed, 15 and 30 km/h are our
            assumption: up to there 3 and 6 m/s2 can still stop the car from a TTC of 1 s. A level that has been
            reached is kept until braking ends.
        brake: dead time and build-up, from another source (seeds 4.4, the rule as printed, not fitted). The fit to
            Table 2 needs others, see `aeb_sumo.reproduction.yan2025`.
    """

    name: ClassVar[str] = "yan2025"
    source: ClassVar[str] = "Yan, Wu, Lin et al. 2025, Automotive Engineer 2025(4) 29-35"
    sensing: ClassVar[str] = "fusion"
    gaze: ClassVar[Gaze] = Gaze.RELATIVE_MOTION

    rule: str = "and"
    lane: float = within(3.8, 0.5, 10.0)
    warn_ttc: float = within(1.2, 0.0, 10.0)
    brake_ttc: float = within(1.0, 0.0, 10.0)
    horizon: float = within(2.5, 0.0, 10.0)
    decel: float = within(9.0, 0.0, 12.0)
    decel_slow: float = within(3.0, 0.0, 12.0)
    decel_medium: float = within(6.0, 0.0, 12.0)
    slow: float = 15 * KMH
    fast: float = 30 * KMH
    brake: BrakeParams = field(
        default_factory=lambda: BrakeParams(dead_time=0.12, lag=0.0, build_up=30.0, release=30.0, open_loop=True)
    )

    def __post_init__(self) -> None:
        """Raises `InputError` for a parameter out of range."""
        super().__post_init__()
        if self.slow > self.fast:
            raise InputError(f"Yan2025.slow must not exceed fast ({self.fast:g}), not {self.slow:g}")
        if self.rule not in _RULES:
            raise InputError(f"Yan2025.rule must be one of {', '.join(_RULES)}, not {self.rule!r}")

    def longest_ttc(self, mu: float) -> float:  # noqa: ARG002
        """See `Strategy.longest_ttc`."""
        return max(self.warn_ttc, self.brake_ttc, self.horizon)

    def init(self, n: int) -> Yan2025State:
        """See `Strategy.init`."""
        return Yan2025State(np.zeros(n, np.int64), np.zeros(n))

    def due(self, percept: Percept, time: float) -> Bools:
        """Whether the rule is met for a time [s].

        Eqs. 1 and 2 give the relative velocity, with a sign that is only right for headings measured from opposite
        directions; here it is own velocity less the target's. `dt1 = Y / dVy` (3), `d1 = dt1 dVx` (4).
        """
        x, y, dvx, dvy = _road_frame(percept)
        meets = (y > 0) & (dvy > 0)
        dt1 = np.divide(y, dvy, out=np.full(len(y), np.inf), where=meets)
        offset = x - np.where(meets, dt1, 0.0) * dvx
        result: Bools = (dt1 <= time) & (np.abs(offset) <= self.lane / 2)
        if self.rule == "lane_entry":
            # Towards the lane from its side: |X| - W <= |dVx| T (seeds 4.4).
            entering = (x * dvx > 0) & (np.abs(x) - self.lane <= np.abs(dvx) * time)
            result |= entering & (dt1 <= self.horizon)
        return result

    def step(self, state: Yan2025State, percept: Percept, dt: float) -> tuple[Yan2025State, Demand]:  # noqa: ARG002
        """See `Strategy.step`. Braking is latched until the car stands or the target has passed (seeds 4.4)."""
        closing = percept.closing_ahead > 0
        alive = percept.valid & (percept.ego_speed > 0) & closing
        braking = alive & ((state.phase >= Phase.PARTIAL_BRAKE) | self.due(percept, self.brake_ttc))
        warning = alive & self.due(percept, self.warn_ttc)
        by_speed = np.select(
            [percept.closing_ahead < self.slow, percept.closing_ahead < self.fast],
            [self.decel_slow, self.decel_medium],
            self.decel,
        )
        decel = np.where(braking, np.maximum(np.where(percept.vulnerable, self.decel, by_speed), state.decel), 0.0)
        full = braking & (decel >= self.decel)
        phase = np.select([full, braking, warning], [Phase.FULL_BRAKE, Phase.PARTIAL_BRAKE, Phase.WARN], Phase.NONE)
        return Yan2025State(phase.astype(np.int64), decel), Demand(phase=phase.astype(np.int64), decel=decel)


def _road_frame(percept: Percept) -> tuple[Floats, Floats, Floats, Floats]:
    """X, Y [m] and dVx, dVy [m/s] of eqs. 1 to 4: Y along the road, X to the left of it.

    The source takes east and north in its one test scene. What a car can know anywhere is the line that the target
    drives on: Y is along that, ahead, when it is within 60 degrees of the own heading, else along the own heading (our
    assumption).
    """
    ahead = np.where(percept.valid, percept.ahead, 0.0)
    target_ahead, target_left = percept.ego_speed - percept.closing_ahead, -percept.closing_left
    speed = np.hypot(target_ahead, target_left)
    aligned = np.abs(target_ahead) > speed / 2
    scale = np.where(target_ahead < 0, -1.0, 1.0) / np.maximum(speed, 1e-9)
    ux, uy = np.where(aligned, target_ahead * scale, 1.0), np.where(aligned, target_left * scale, 0.0)
    return (
        ux * percept.left - uy * ahead,
        ux * ahead + uy * percept.left,
        ux * percept.closing_left - uy * percept.closing_ahead,
        ux * percept.closing_ahead + uy * percept.closing_left,
    )


STRATEGY = Yan2025
