"""Zheng et al. 2020: TTC thresholds from the reaction time of the driver's class, fuzzy control of the deceleration.

Zheng G., Zu Z., Kong Z.: AEB collision avoidance strategy based on driver reaction time. Journal of Chongqing
University of Technology (Natural Science), 2020 no. 12. "seeds" is shared/seeds.md, section 5 and A26 ... A28.

The relations T_i(v), the membership functions and the rules are lost. What stands in for them here is **synthetic**:
invented, so that the published results come out (seeds 5.3, D3, D4).
"""

from dataclasses import dataclass, field
from functools import cache
from typing import ClassVar

import numpy as np

from aeb_sumo.criticality import ttc2
from aeb_sumo.drivers.classes import CLASSES, driver_classes, reaction_time
from aeb_sumo.fuzzy import RuleBase, Surface
from aeb_sumo.parameters import within
from aeb_sumo.soa import Bools, Floats
from aeb_sumo.strategies.base import Demand, Gaze, Percept, Phase, Strategy
from aeb_sumo.units import to_kmh
from aeb_sumo.vehicle.brake import BrakeParams

__all__ = ["STRATEGY", "Zheng2020", "Zheng2020State", "rule_base"]

# Synthetic: the output set nearest to v^2 / (2 max(d - 1.305, 0.25)). Rows v_rel N0..N6, columns d P0..P6; an entry k
# stands for the output set Zk.
_RULES = """
0 0 0 0 0 0 0
2 2 0 0 0 0 0
6 6 2 1 1 0 0
6 6 6 3 2 1 1
6 6 6 5 3 2 2
6 6 6 6 5 4 3
6 6 6 6 6 5 4
"""


def rule_base() -> RuleBase:
    """The fuzzy upper controller: closing speed [km/h] and gap [m] to deceleration [m/s2].

    Seven Gaussian sets for each of the three, Mamdani inference and the centroid are printed; the universes, centres,
    widths and rules are synthetic, our assumption (seeds 5.3).
    """
    v = np.array([0, 3.7, 10.8, 20.3, 31.9, 45.1, 60])
    d = np.array([0, 0.9, 3.5, 7.74, 13.58, 21.01, 30])
    a = np.array([0, 0.65, 1.72, 3.03, 4.53, 6.2, 8])
    return RuleBase(
        x_range=(0.0, 60.0),
        y_range=(0.0, 30.0),
        z_range=(0.0, 8.0),
        x_sets=np.column_stack([v, 0.34 * np.gradient(v)]),
        y_sets=np.column_stack([d, 0.244 * np.gradient(d)]),
        z_sets=np.column_stack([a, 0.158 * np.gradient(a)]),
        rules=np.array([[int(k) for k in row.split()] for row in _RULES.split("\n") if row]),
    )


@cache
def _surface() -> Surface:
    """The control surface, synthetic."""
    return rule_base().surface()


@dataclass(frozen=True)
class Zheng2020State:
    """Memory, (n,): the system brakes."""

    braking: Bools


@dataclass(frozen=True, kw_only=True)
class Zheng2020(Strategy):
    """The system with its parameters.

    Attributes:
        driver_class: 1 (the slowest reactions) to 4, printed; that it is 1 unless told otherwise is our assumption.
        classes_file: lines of reaction time as `aeb_sumo.drivers.classes.driver_classes` reads them; empty for the
            packaged synthetic ones, our assumption.
        lost_time: brake clearance and hydraulic delay t0 [s], printed.
        brake: first-order lag of 0.157 s without dead time, our assumption (seeds 5.3).
    """

    name: ClassVar[str] = "zheng2020"
    source: ClassVar[str] = "Zheng, Zu, Kong 2020, Journal of Chongqing University of Technology (Nat. Sci.) no. 12"
    gaze: ClassVar[Gaze] = Gaze.LEAD  # the source treats the vehicle ahead alone (seeds 5.1: CCRs)

    driver_class: int = within(1, 1, CLASSES)
    classes_file: str = ""
    lost_time: float = 0.2
    brake: BrakeParams = field(
        default_factory=lambda: BrakeParams(dead_time=0.0, lag=0.157, open_loop=True, build_up=np.inf, release=np.inf)
    )

    def __post_init__(self) -> None:
        """Raises `InputError` for a parameter out of range or a file that is not one of driver classes."""
        super().__post_init__()
        driver_classes(self.classes_file or None)

    def longest_ttc(self, mu: float) -> float:  # noqa: ARG002
        """See `Strategy.longest_ttc`."""
        return float(self.warn_threshold(np.linspace(0.0, 40.0, 41)).max())

    def init(self, n: int) -> Zheng2020State:
        """See `Strategy.init`."""
        return Zheng2020State(np.zeros(n, np.bool_))

    def brake_threshold(self, closing_speed: Floats) -> Floats:
        """`TTC_i(v) = T_i(v) + t0` [s] for a closing speed [m/s]; braking starts there.

        v is the relative speed, over which the lines were fitted; where the source gives the thresholds it says m/s,
        the lines are in km/h.
        """
        classes = driver_classes(self.classes_file or None)
        return reaction_time(classes, self.driver_class, to_kmh(closing_speed)) + self.lost_time

    def warn_threshold(self, closing_speed: Floats) -> Floats:
        """`2 (T_i(v) + t0)` [s]: warning starts there (A26).

        The text says twice the reaction time, without t0. Its worked example, 3.0 s to warn and 1.5 s less to brake,
        contradicts that: with warning at 2 T = 3.0 s and braking at T + 0.2 s they would be 1.3 s apart (D2).
        """
        return 2 * self.brake_threshold(closing_speed)

    def step(self, state: Zheng2020State, percept: Percept, dt: float) -> tuple[Zheng2020State, Demand]:  # noqa: ARG002
        """See `Strategy.step`. Levels I to III of the source: nothing, warning, braking until standstill.

        There is one level of braking, whose deceleration is the fuzzy controller's.
        """
        closing = percept.ego_speed - percept.target_speed
        time = ttc2(gap=percept.gap, closing_speed=closing, closing_accel=percept.ego_accel - percept.target_accel)
        alive: Bools = percept.valid & (percept.ego_speed > 0) & (closing > 0)

        braking = alive & (state.braking | (time <= self.brake_threshold(closing)))
        warning = alive & (time <= self.warn_threshold(closing))
        decel = np.zeros(len(braking))
        rows = np.flatnonzero(braking)
        if len(rows):
            decel[rows] = _surface()(to_kmh(closing[rows]), percept.gap[rows])
        phase = np.select([braking, warning], [Phase.PARTIAL_BRAKE, Phase.WARN], Phase.NONE)
        return Zheng2020State(braking), Demand(phase=phase.astype(np.int64), decel=decel)


STRATEGY = Zheng2020
