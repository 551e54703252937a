"""Zhao et al. 2025: second-order TTC to warn, modified safety distance to brake, fuzzy and PID control.

Zhao H., Guo Z., Liu Z.: A Car-Following Control Strategy for AEB Systems Balancing Safety and Comfort. Chinese Journal
of Automotive Engineering 15(4), 445-456, 2025. Equation and table numbers below are this paper's; "seeds" is
shared/seeds.md, where what the paper leaves open is decided (A1 ... A11).

The paper treats the vehicle ahead alone. That the system brakes for crossing traffic as well, as if that stood where
the paths cross, is our extension (`Gaze.PATH`).
"""

from dataclasses import dataclass, field
from functools import cache
from typing import ClassVar

import numpy as np

from aeb_sumo.criticality import ttc2
from aeb_sumo.fuzzy import RuleBase, Surface
from aeb_sumo.parameters import within
from aeb_sumo.soa import Bools, Floats, Ints, take
from aeb_sumo.strategies.base import Demand, Percept, Phase, Strategy
from aeb_sumo.units import KMH, G, to_kmh
from aeb_sumo.vehicle.brake import BrakeParams
from aeb_sumo.vehicle.tuning import tuned

__all__ = ["STRATEGY", "Zhao2025", "Zhao2025State", "rule_base"]

# Table 5 (printed): rows v_rel Z0, N1..N9, columns d Z0, P1..P8; an entry k stands for the output set Nk.
_TABLE_5 = """
2 0 0 0 0 0 0 0 0
3 2 1 1 0 0 0 0 0
5 3 2 2 1 0 0 0 0
6 4 3 2 1 1 0 0 0
6 6 5 4 3 2 1 0 0
7 6 6 5 4 3 2 2 1
7 7 6 6 5 3 3 2 2
7 7 7 6 6 5 4 3 2
7 7 7 7 7 6 5 4 3
7 7 7 7 7 6 6 5 4
"""


def rule_base() -> RuleBase:
    """The fuzzy upper controller: closing speed [km/h] and gap [m] to deceleration [m/s2].

    Universes and rules are printed (2.1, Table 5); the signs are turned, so that closing and braking are positive. The
    membership functions (Figure 5) are lost: centres and widths are from another source, the fit of seeds 8 (A5) to
    the published results, Gaussian inputs and generalised-bell outputs with b = 2.5.
    """
    v = 100 * (np.arange(10) / 9) ** 1.58
    d = 60 * (np.arange(9) / 8) ** 1.24
    a = 8 * (np.arange(8) / 7) ** 1.16
    return RuleBase(
        x_range=(0.0, 100.0),
        y_range=(0.0, 60.0),
        z_range=(0.0, 8.0),
        x_sets=np.column_stack([v, 0.27 * np.gradient(v)]),
        y_sets=np.column_stack([d, 0.17 * np.gradient(d)]),
        z_sets=np.column_stack([a, 0.39 * np.gradient(a), np.full(8, 2.5)]),
        rules=np.array([[int(k) for k in row.split()] for row in _TABLE_5.split("\n") if row]),
    )


@cache
def _surface() -> Surface:
    """The control surface, within 0.02 m/s2 of inference at the points of tests/reference/test_fuzzy.py."""
    return rule_base().surface()


def _brake() -> BrakeParams:
    return BrakeParams(dead_time=0.0, lag=0.05, build_up=np.inf, release=np.inf, pid=tuned(lag=0.05, dead_time=0.0))


@dataclass(frozen=True)
class Zhao2025State:
    """Memory, (n,) each: `Phase`, and the thresholds latched when the warning began (A7)."""

    phase: Ints
    ttc_threshold: Floats
    omega_threshold: Floats


@dataclass(frozen=True, kw_only=True)
class Zhao2025(Strategy):
    """The system with its parameters.

    Attributes:
        reaction_time: driver's reaction t1 [s], printed (section 1.2).
        t2_free: t2', pedal and actuator free travel [s], printed as "actuator time 0.15 s" (A2).
        t2_build: t2'', linear build-up [s], from another source (seeds A2: minimax over the published distances).
        comfort_decel: deceleration in the safety distance [m/s2], printed (eq. 4).
        ttc_slow, ttc_fast: TTC2 threshold up to and above `fast` [s], printed (Table 3).
        omega_slow, omega_fast: level-2 threshold up to and above `fast`, printed (Table 4).
        fast: speed that divides the two [m/s], printed (60 km/h).
        ttc_release: a warning ends when TTC2 exceeds its threshold by this [s], from another source (seeds 1.4).
        omega_release: level 2 ends when omega exceeds its threshold by this, from another source (seeds 1.4).
        standing: a target slower than this counts as standing [m/s], our assumption.
        braking: a target that slows down by more than this counts as braking [m/s2], from another source (A9).
        dead_band: demands below this are dropped while the gap exceeds the braking distance [m/s2], from another
            source (seeds 8).
        sampling: cycle of the system [s], from another source (A6: all printed times are multiples of 0.04 s).
        brake: first-order lag of 0.05 s without dead time, from another source (seeds 8); gains by particle swarm, as
            printed (2.2), within bounds that are not (`aeb_sumo.vehicle.tuning`).
    """

    name: ClassVar[str] = "zhao2025"
    source: ClassVar[str] = "Zhao, Guo, Liu 2025, Chinese Journal of Automotive Engineering 15(4) 445-456"

    reaction_time: float = 1.36
    t2_free: float = 0.15
    t2_build: float = 0.14
    comfort_decel: float = within(6.5, 0.5, 12.0)
    ttc_slow: float = 2.6
    ttc_fast: float = 2.8
    omega_slow: float = within(-0.7, -10.0, 10.0)
    omega_fast: float = within(-0.6, -10.0, 10.0)
    fast: float = 60 * KMH
    ttc_release: float = 0.2
    omega_release: float = 0.02
    standing: float = 0.1
    braking: float = 0.5
    dead_band: float = 0.3
    sampling: float = within(0.04, 0.0, 0.5)
    brake: BrakeParams = field(default_factory=_brake)

    @property
    def cycle(self) -> float:
        """See `Strategy.cycle`."""
        return self.sampling

    def init(self, n: int) -> Zhao2025State:
        """See `Strategy.init`."""
        _surface()  # ready before the first step
        return Zhao2025State(np.zeros(n, np.int64), np.full(n, self.ttc_slow), np.full(n, self.omega_slow))

    def max_decel(self, mu: Floats) -> Floats:
        """`a_bmax = mu g - 1` (eq. 3) [m/s2], not below 0.5 (seeds 1.4)."""
        return np.maximum(mu * G - 1.0, 0.5)

    def braking_distance(self, percept: Percept) -> Floats:
        """Critical braking distance S_b [m], Table 2, with d0 of eq. 5.

        The deceleration is |a1| of eq. 4, as the text below Table 2 says; the table prints a_bmax (A3). The third row
        prints `+ v2^2 / (2 a2)`, which is right with a2 < 0; it is never less than the second (A9). d0 is taken with
        the final speed of both: 0 behind a lead that stands or brakes, else the lead's (A4).
        """
        v1, v2 = percept.ego_speed, percept.target_speed
        v_rel = np.maximum(v1 - v2, 0.0)
        tau = self.t2_free + self.t2_build / 2
        a1 = np.minimum(self.comfort_decel, self.max_decel(percept.mu))

        def distance(v: Floats, v_end: Floats | float) -> Floats:
            d0 = 0.36 * v_end + 1.4
            result: Floats = v * tau + v**2 / (2 * a1) + d0
            return result

        steady = distance(v_rel, np.maximum(v2, 0.0))
        braking = distance(v1, 0.0) - v2**2 / (2 * np.maximum(-percept.target_accel, self.braking))
        return np.where(
            v2 < self.standing,
            distance(v1, 0.0),
            np.where(percept.target_accel < -self.braking, np.maximum(braking, steady), steady),
        )

    def omega(self, percept: Percept, braking_distance: Floats) -> Floats:
        """Danger coefficient `(d - S_b) / (S_w - S_b)`, `S_w - S_b = v1 t1` (eq. 2).

        The paper uses omega without defining it; this reading fits its results best (A1).
        """
        return (percept.gap - braking_distance) / np.maximum(percept.ego_speed * self.reaction_time, 0.5)

    def step(self, state: Zhao2025State, percept: Percept, dt: float) -> tuple[Zhao2025State, Demand]:  # noqa: ARG002
        """See `Strategy.step`. Warning: Figure 3 and Table 3; braking: Figure 4 and Table 4; seeds 1.4."""
        closing = percept.ego_speed - percept.target_speed
        time = ttc2(gap=percept.gap, closing_speed=closing, closing_accel=percept.ego_accel - percept.target_accel)
        # Closing includes v_rel = 0 with a_rel > 0, the first row of Table 1.
        alive: Bools = percept.valid & (percept.ego_speed > 0) & (closing >= 0)

        idle = state.phase == Phase.NONE
        is_fast = percept.ego_speed > self.fast
        ttc_threshold = np.where(idle, np.where(is_fast, self.ttc_fast, self.ttc_slow), state.ttc_threshold)
        omega_threshold = np.where(idle, np.where(is_fast, self.omega_fast, self.omega_slow), state.omega_threshold)

        was_braking = state.phase >= Phase.PARTIAL_BRAKE
        warning = alive & (time <= np.where(idle, ttc_threshold, ttc_threshold + self.ttc_release))
        phase, decel = np.where(warning, int(Phase.WARN), int(Phase.NONE)), np.zeros(len(warning))
        # Few get any further. Braking goes on until the closing speed is gone (seeds 1.4); it starts only out of a
        # warning.
        rows = ((warning | was_braking) & alive & (closing > 0)).nonzero()[0]
        if len(rows):
            few = take(percept, rows)
            s_b = self.braking_distance(few)
            braking = was_braking[rows] | (few.gap <= s_b)
            release = np.where(state.phase[rows] == Phase.FULL_BRAKE, self.omega_release, 0.0)
            full = braking & (self.omega(few, s_b) <= omega_threshold[rows] + release)
            limit = self.max_decel(few.mu)
            fuzzy = np.minimum(_surface()(to_kmh(closing[rows]), few.gap), limit)
            fuzzy = np.where((few.gap > s_b) & (fuzzy < self.dead_band), 0.0, fuzzy)
            decel[rows] = np.where(full, limit, np.where(braking, fuzzy, 0.0))
            phase[rows] = np.select([full, braking], [Phase.FULL_BRAKE, Phase.PARTIAL_BRAKE], phase[rows])
        return Zhao2025State(phase, ttc_threshold, omega_threshold), Demand(phase=phase, decel=decel)


STRATEGY = Zhao2025
