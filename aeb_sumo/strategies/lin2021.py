"""Lin et al. 2021: time-to-collision thresholds that follow the friction of the road.

Lin G., Lu C., Han L., Liu J.: Co-simulation of Active Braking and Collision Avoidance Algorithm for Intelligent
Connected Vehicles. Computer Technology and Development 31(7), 1-6, 2021. Equation numbers below are this paper's;
"seeds" is shared/seeds.md, section 2 and A12 ... A18.
"""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from aeb_sumo.criticality import ttc2
from aeb_sumo.parameters import within
from aeb_sumo.soa import Floats, Ints
from aeb_sumo.strategies.base import Demand, Gaze, Percept, Phase, Strategy
from aeb_sumo.units import G
from aeb_sumo.vehicle.brake import BrakeParams

__all__ = ["STRATEGY", "Lin2021", "Lin2021State"]


def _brake() -> BrakeParams:
    table = ((0.3, 0.606), (0.5, 0.317), (0.7, 0.277), (0.8, 0.264))
    return BrakeParams(dead_time_by_mu=table, lag=0.0, build_up=np.inf, release=np.inf, open_loop=True)


@dataclass(frozen=True)
class Lin2021State:
    """Memory: (n,) `Phase` of the last step."""

    phase: Ints


@dataclass(frozen=True, kw_only=True)
class Lin2021(Strategy):
    """The system with its parameters: profile R2 of seeds 2.4.

    Attributes:
        t1: driver's reaction [s], printed as 0.3 to 1.0; the lower bound reproduces the results (A13).
        t2: delay of the brakes [s], printed as 0.2 to 0.9; the lower bound (A13).
        t3: delay of the controller [s], printed as 0.1 to 0.3; the lower bound (A13).
        c_emergency: braking distance in units of `v^2 / (mu g)`; 0.625 is printed in eq. 22, which eq. 23 contradicts
            with 0.5. The results agree with the former (A12).
        c_warning: the same for the warning; 0.75 is printed in eq. 22, against 0.833 in eq. 23.
        knows_road: a vehicle enters with the friction of that place; otherwise with `prior`, our assumption. Nothing
            can be learned before the first braking (seeds 2.4): the published results need it.
        prior: see `knows_road`; 0.8, the friction of the fixed rival, our assumption.
        brake: full deceleration at once after a dead time that depends on the road, from another source (seeds 2.4,
            A14: an empirical table, not a finding about brakes).
    """

    name: ClassVar[str] = "lin2021"
    source: ClassVar[str] = "Lin, Lu, Han, Liu 2021, Computer Technology and Development 31(7) 1-6"
    gaze: ClassVar[Gaze] = Gaze.LEAD  # the source treats the vehicle ahead alone (seeds 2.2)
    estimates_friction: ClassVar[bool] = True

    t1: float = within(0.3, 0.0, 3.0)
    t2: float = within(0.2, 0.0, 3.0)
    t3: float = within(0.1, 0.0, 3.0)
    c_emergency: float = within(0.625, 0.1, 5.0)
    c_warning: float = within(0.75, 0.1, 5.0)
    knows_road: bool = True
    prior: float = within(0.8, 0.05, 1.2)
    brake: BrakeParams = field(default_factory=_brake)

    @property
    def friction_prior(self) -> float | None:
        """See `Strategy.friction_prior`."""
        return None if self.knows_road else self.prior

    def longest_ttc(self, mu: float) -> float:
        """See `Strategy.longest_ttc`."""
        return self.c_warning * 40.0 / (mu * G) + self.t1 + self.t2 + self.t3

    def init(self, n: int) -> Lin2021State:
        """See `Strategy.init`."""
        return Lin2021State(np.zeros(n, np.int64))

    def friction(self, percept: Percept) -> Floats:
        """The friction coefficient that the thresholds and the demand are made of."""
        return percept.mu

    def thresholds(self, percept: Percept) -> tuple[Floats, Floats]:
        """Warning and emergency thresholds TTC_w and TTC_e [s] (eqs. 21 to 23); `inf` where the gap opens in time.

        The distance `s = c v^2 / (mu g) + v T`, turned into a time by the second-order law, in the form
        `2 s / (v + sqrt(v^2 + 2 a s))`. As printed, eqs. 19, 20 and 22 mix the signs of `v_r` and `mu_r g`, so that the
        root is negative or does not exist (seeds 2.1).
        """
        v = np.maximum(percept.ego_speed - percept.target_speed, 0.0)
        a = percept.ego_accel - percept.target_accel
        grip = self.friction(percept) * G

        def time(c: float, delay: float) -> Floats:
            return ttc2(gap=c * v**2 / grip + v * delay, closing_speed=v, closing_accel=a)

        return time(self.c_warning, self.t1 + self.t2 + self.t3), time(self.c_emergency, self.t1 + self.t2)

    def step(self, state: Lin2021State, percept: Percept, dt: float) -> tuple[Lin2021State, Demand]:  # noqa: ARG002
        """See `Strategy.step`. State machine of seeds 2.3; the emergency lasts until nothing closes in any more."""
        closing = percept.ego_speed - percept.target_speed
        time = ttc2(gap=percept.gap, closing_speed=closing, closing_accel=percept.ego_accel - percept.target_accel)
        warning, emergency = self.thresholds(percept)
        alive = percept.valid & (percept.ego_speed > 0) & (closing > 0)
        meets = alive & np.isfinite(time)
        braking = (alive & (state.phase == Phase.FULL_BRAKE)) | (meets & (time <= emergency))
        phase = np.select([braking, meets & (time <= warning)], [Phase.FULL_BRAKE, Phase.WARN], Phase.NONE)
        decel = np.where(braking, self.friction(percept) * G, 0.0)
        return Lin2021State(phase.astype(np.int64)), Demand(phase=phase.astype(np.int64), decel=decel)


STRATEGY = Lin2021
