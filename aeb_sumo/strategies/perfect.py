"""The ceiling of braking: a perfect sensor, and all that the road gives at once. No system, but what none can exceed.

Whoever brakes fully from some instant on is, at every later instant, behind all who brake otherwise from then on. So
behind a lead nobody can do better. Nor can anyone at a crossing: who would be hit without braking leaves the crossing
too late however he brakes, and only arriving after the other has gone helps, which full braking does best. What is left
is from which instant on: see `horizon` and `share`.
"""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from aeb_sumo.criticality import required_decel, time_to_contact
from aeb_sumo.parameters import within
from aeb_sumo.soa import Bools, Floats
from aeb_sumo.strategies.base import Demand, Percept, Phase, Strategy
from aeb_sumo.units import G
from aeb_sumo.vehicle.brake import BrakeParams

__all__ = ["STRATEGY", "Perfect", "PerfectState", "speed_matching"]

_ROUNDING = 1e-6  # m/s, two speeds nearer than this are equal


def speed_matching(percept: Percept, dt: float, most: Floats) -> Floats:
    """(n,) deceleration up to `most` (n,) that brings the own speed down to the target's within a step, and no lower.

    0 where the gap opens, or the ego stands; where there is no target it means nothing [m/s2].
    """
    closing = percept.ego_speed - percept.target_speed
    meets = (percept.ego_speed > 0) & (closing >= -_ROUNDING)
    wanted = np.clip(np.maximum(closing, 0.0) / dt - percept.target_accel, 0.0, most)
    return np.where(meets, wanted, 0.0)


@dataclass(frozen=True)
class PerfectState:
    """Memory, (n,): it brakes."""

    braking: Bools


@dataclass(frozen=True, kw_only=True)
class Perfect(Strategy):
    """Brakes from the first instant at which a crash is on its way, until nothing closes in any more.

    A crash is on its way when both would touch if they kept their accelerations (a crossing vehicle stands for what it
    will be in the way of: where the paths cross), and this within `horizon`, or so that it takes more than `share` of
    what the road gives to prevent it.

    Attributes:
        horizon: [s], our assumption: longer than any system here waits for on a dry road; without one, omniscience
            would brake minutes before.
        share: 0 to 1, our assumption: it counts at speeds, and on roads, at which the horizon is too short to stop in,
            and is more than drivers use who see what is coming.
        brake: without dead time, build-up or lag.
    """

    name: ClassVar[str] = "perfect"
    source: ClassVar[str] = "a ceiling of our own: true states, line of sight, mu g at once"
    sensing: ClassVar[str] = "perfect"

    horizon: float = within(3.0, 0.0, 60.0)
    share: float = within(0.6, 0.01, 1.0)
    brake: BrakeParams = field(
        default_factory=lambda: BrakeParams(dead_time=0.0, lag=0.0, build_up=np.inf, release=np.inf, open_loop=True)
    )

    def longest_ttc(self, mu: float) -> float:
        """See `Strategy.longest_ttc`."""
        return max(self.horizon, 40.0 / (2 * self.share * mu * G))

    def init(self, n: int) -> PerfectState:
        """See `Strategy.init`."""
        return PerfectState(np.zeros(n, np.bool_))

    def threatened(self, percept: Percept) -> Bools:
        """(n,) whether a crash is on its way."""
        p = percept
        time = time_to_contact(
            gap=p.gap, speed=p.ego_speed, accel=p.ego_accel, lead_speed=p.target_speed, lead_accel=p.target_accel
        )
        needed = required_decel(
            gap=p.gap, speed=p.ego_speed, lead_speed=np.maximum(p.target_speed, 0.0), lead_accel=p.target_accel
        )
        result: Bools = np.isfinite(time) & ((time <= self.horizon) | (needed >= self.share * p.mu * G))
        return result

    def step(self, state: PerfectState, percept: Percept, dt: float) -> tuple[PerfectState, Demand]:
        """See `Strategy.step`."""
        most = percept.mu * G
        braking = percept.valid & (state.braking | self.threatened(percept))
        decel = np.where(braking, speed_matching(percept, dt, most), 0.0)
        phase = np.select([decel >= most, decel > 0], [Phase.FULL_BRAKE, Phase.PARTIAL_BRAKE], Phase.NONE)
        phase = np.where(decel > 0, phase, Phase.NONE).astype(np.int64)
        return PerfectState(decel > 0), Demand(phase=phase, decel=decel)


STRATEGY = Perfect
