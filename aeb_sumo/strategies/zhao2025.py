"""Zhao et al. 2025: second-order TTC to warn, modified safety distance to brake, fuzzy and PID control.

Zhao H., Guo Z., Liu Z.: A Car-Following Control Strategy for AEB Systems Balancing Safety and Comfort. Chinese Journal
of Automotive Engineering 15(4), 445-456, 2025. Equation and table numbers below are this paper's; "seeds" is
shared/seeds.md, where what the paper leaves open is decided (A1 ... A11).

The paper treats the vehicle ahead alone. That the system brakes for crossing traffic as well, as if that stood where
the paths cross, is our extension (`Gaze.PATH`).
"""

from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import ClassVar

import numpy as np

from aeb_sumo.compiled import kernel
from aeb_sumo.criticality import ttc2
from aeb_sumo.fuzzy import RuleBase, Surface
from aeb_sumo.parameters import within
from aeb_sumo.soa import Bools, Floats, Ints
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
        return _braking_distances(
            percept.ego_speed, percept.target_speed, percept.target_accel, percept.mu, *self._brakes
        )

    @cached_property
    def _brakes(self) -> tuple[float, float, float, float]:
        """What the braking distance depends on besides the percept."""
        return self.t2_free + self.t2_build / 2, self.comfort_decel, self.standing, self.braking

    def step(self, state: Zhao2025State, percept: Percept, dt: float) -> tuple[Zhao2025State, Demand]:  # noqa: ARG002
        """See `Strategy.step`. Warning: Figure 3 and Table 3; braking: Figure 4 and Table 4; seeds 1.4."""
        closing = percept.ego_speed - percept.target_speed
        time = ttc2(gap=percept.gap, closing_speed=closing, closing_accel=percept.ego_accel - percept.target_accel)
        phase, decel, s_b, *latched = _decided(
            state.phase, state.ttc_threshold, state.omega_threshold, percept.valid, time, percept.gap,
            percept.ego_speed, percept.target_speed, percept.target_accel, percept.mu,
            self.fast, self.ttc_slow, self.ttc_fast, self.ttc_release, self.omega_slow, self.omega_fast,
            self.omega_release, self.reaction_time, *self._brakes,
        )  # fmt: skip
        rows = (phase == Phase.PARTIAL_BRAKE).nonzero()[0]
        if len(rows):
            gap = percept.gap[rows]
            fuzzy = np.minimum(_surface()(to_kmh(closing[rows]), gap), self.max_decel(percept.mu[rows]))
            decel[rows] = np.where((gap > s_b[rows]) & (fuzzy < self.dead_band), 0.0, fuzzy)
        return Zhao2025State(phase, *latched), Demand(phase=phase, decel=decel)


_NONE, _WARN, _PARTIAL, _FULL = (int(phase) for phase in Phase)


@kernel
def _decided(
    phase: Ints, ttc_threshold: Floats, omega_threshold: Floats, valid: Bools, time: Floats, gap: Floats,
    v1: Floats, v2: Floats, a2: Floats, mu: Floats,
    fast: float, ttc_slow: float, ttc_fast: float, ttc_release: float, omega_slow: float, omega_fast: float,
    omega_release: float, reaction_time: float, tau: float, comfort: float, standing: float, brakes: float,
) -> tuple[Ints, Floats, Floats, Floats, Floats]:  # fmt: skip
    """New phases, decelerations but for partial braking, braking distances, and both thresholds as latched."""
    n = len(phase)
    new, decel, distance = np.full(n, _NONE), np.zeros(n), np.zeros(n)
    ttc_latched, omega_latched = ttc_threshold.copy(), omega_threshold.copy()
    for k in range(n):
        idle, was_braking = phase[k] == _NONE, phase[k] >= _PARTIAL
        if idle:
            ttc_latched[k] = ttc_fast if v1[k] > fast else ttc_slow
            omega_latched[k] = omega_fast if v1[k] > fast else omega_slow
        # Closing includes v_rel = 0 with a_rel > 0, the first row of Table 1.
        if not (valid[k] and v1[k] > 0 and v1[k] - v2[k] >= 0):
            continue
        warning = time[k] <= (ttc_latched[k] if idle else ttc_latched[k] + ttc_release)
        if warning:
            new[k] = _WARN
        # Braking goes on until the closing speed is gone (seeds 1.4); it starts only out of a warning.
        if not ((warning or was_braking) and v1[k] - v2[k] > 0):
            continue
        s_b = distance[k] = _braking_distance(v1[k], v2[k], a2[k], mu[k], tau, comfort, standing, brakes)
        if was_braking or gap[k] <= s_b:
            release = omega_release if phase[k] == _FULL else 0.0
            # Danger coefficient `(d - S_b) / (S_w - S_b)`, `S_w - S_b = v1 t1` (eq. 2). The paper uses omega without
            # defining it; this reading fits its results best (A1).
            omega = (gap[k] - s_b) / max(v1[k] * reaction_time, 0.5)
            new[k] = _FULL if omega <= omega_latched[k] + release else _PARTIAL
            decel[k] = _max_decel(mu[k]) if new[k] == _FULL else 0.0
    return new, decel, distance, ttc_latched, omega_latched


@kernel
def _braking_distances(
    v1: Floats, v2: Floats, a2: Floats, mu: Floats, tau: float, comfort: float, standing: float, brakes: float
) -> Floats:
    result = np.empty(len(v1))
    for k in range(len(v1)):
        result[k] = _braking_distance(v1[k], v2[k], a2[k], mu[k], tau, comfort, standing, brakes)
    return result


@kernel
def _braking_distance(
    v1: float, v2: float, a2: float, mu: float, tau: float, comfort: float, standing: float, brakes: float
) -> float:
    """Table 2; see `Zhao2025.braking_distance`."""
    a1 = min(comfort, _max_decel(mu))
    to_standstill = v1 * tau + v1 * v1 / (2 * a1) + 1.4
    if v2 < standing:
        return to_standstill
    v_rel = max(v1 - v2, 0.0)
    steady = v_rel * tau + v_rel * v_rel / (2 * a1) + (0.36 * max(v2, 0.0) + 1.4)
    if a2 < -brakes:
        return max(to_standstill - v2 * v2 / (2 * max(-a2, brakes)), steady)
    return steady


@kernel
def _max_decel(mu: float) -> float:
    """`a_bmax = mu g - 1` (eq. 3) [m/s2], not below 0.5 (seeds 1.4)."""
    return max(mu * G - 1.0, 0.5)


STRATEGY = Zhao2025
