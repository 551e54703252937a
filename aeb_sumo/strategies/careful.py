"""The careful and competent driver of UN R157 at the brake: what a good driver with his eyes on the road would do.

UN R157 describes him in its Annex 4, Appendix 3, as the measure of what an automated vehicle has to avoid; the numbers
are those of evidence.md (read in the code of JRC and esmini). `aeb_sumo.drivers.reactions.Careful` is the same driver
as a model of reactions to leads, for all drivers of a run; this one takes the place of an AEB, and so acts for one
vehicle, on top of what its own driver does, and for crossing traffic too, which is our extension.
"""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from aeb_sumo.criticality import time_to_contact, ttc
from aeb_sumo.parameters import within
from aeb_sumo.soa import Bools, Floats
from aeb_sumo.strategies.base import Demand, Percept, Phase, Strategy
from aeb_sumo.strategies.perfect import speed_matching
from aeb_sumo.units import G
from aeb_sumo.vehicle.brake import BrakeParams

__all__ = ["STRATEGY", "CarefulDriver", "CarefulState"]


@dataclass(frozen=True)
class CarefulState:
    """Memory, (n,) each.

    Attributes:
        due: time left until the foot is on the brake; inf while no risk has been seen [s].
        braking: it is.
    """

    due: Floats
    braking: Bools


@dataclass(frozen=True, kw_only=True)
class CarefulDriver(Strategy):
    """He sees a risk, brakes after his reaction time, and goes on until nothing closes in any more.

    A risk that is over before he has reacted (the two would not touch any more if both kept their accelerations) is
    none. He sees what `aeb_sumo.strategies.perfect` sees: what he lacks of it is time and force alone.

    Attributes:
        risk_ttc: risk is seen at this TTC [s], from another source (UN R157) ...
        surprise: ... and at once in a target that brakes with this or more, if the two would touch [m/s2], from another
            source (esmini's code).
        delay: reaction time [s], from another source (UN R157).
        decel: 0.774 g [m/s2], from another source (UN R157).
        brake: builds up with 12.65 m/s3, from another source (UN R157), and nothing else delays it.
    """

    name: ClassVar[str] = "careful"
    source: ClassVar[str] = "UN Regulation No. 157, Annex 4, Appendix 3: the careful and competent human driver"
    sensing: ClassVar[str] = "perfect"

    risk_ttc: float = within(2.0, 0.1, 60.0)
    surprise: float = 5.0
    delay: float = within(0.75, 0.0, 10.0)
    decel: float = within(0.774 * G, 0.1, 15.0)
    brake: BrakeParams = field(
        default_factory=lambda: BrakeParams(dead_time=0.0, lag=0.0, build_up=12.65, release=np.inf, open_loop=True)
    )

    def longest_ttc(self, mu: float) -> float:  # noqa: ARG002
        """See `Strategy.longest_ttc`."""
        return self.risk_ttc

    def init(self, n: int) -> CarefulState:
        """See `Strategy.init`."""
        return CarefulState(np.full(n, np.inf), np.zeros(n, np.bool_))

    def step(self, state: CarefulState, percept: Percept, dt: float) -> tuple[CarefulState, Demand]:
        """See `Strategy.step`."""
        p = percept
        contact = time_to_contact(
            gap=p.gap, speed=p.ego_speed, accel=p.ego_accel, lead_speed=p.target_speed, lead_accel=p.target_accel
        )
        soon = ttc(gap=p.gap, closing_speed=p.ego_speed - p.target_speed) <= self.risk_ttc
        seen = soon | (p.target_accel <= -self.surprise) | np.isfinite(state.due)
        risk = p.valid & (p.ego_speed > 0) & ((seen & np.isfinite(contact)) | state.braking)
        due = np.where(risk, np.minimum(state.due, self.delay), np.inf)
        braking = risk & (due <= dt / 2)
        most = np.minimum(self.decel, p.mu * G)
        decel = np.where(braking, speed_matching(p, dt, most), 0.0)
        phase = np.where(decel > 0, np.where(decel >= most, Phase.FULL_BRAKE, Phase.PARTIAL_BRAKE), Phase.NONE)
        state = CarefulState(np.where(braking, np.minimum(due, 0.0), due - dt), decel > 0)
        return state, Demand(phase=phase.astype(np.int64), decel=decel)


STRATEGY = CarefulDriver
