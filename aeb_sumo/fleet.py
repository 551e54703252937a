"""The arrays of all equipped vehicles, and the pipeline over them: perception -> strategy -> brake."""

from dataclasses import dataclass

import numpy as np

from aeb_sumo.criticality import ttc, ttc2
from aeb_sumo.perception.crossing import Approach, conflicting
from aeb_sumo.perception.lead import sees_lead
from aeb_sumo.perception.sensor import Sensor, covered
from aeb_sumo.soa import Bools, Floats, Ints, fitted, put, take
from aeb_sumo.strategies.base import Demand, Percept, Phase, Strategy
from aeb_sumo.vehicle.brake import brake_init, brake_step
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.paths import Paths, Turn
from aeb_sumo.world.surroundings import leaders

__all__ = ["Fleet", "Target", "Targets"]

_ELSEWHERE = 2.0  # m, another target farther away than the last by more than this is another matter, our assumption
_RELEASED = 0.05  # m/s2, a brake below this is off
_HOLDING = 3.0  # m/s2, of a brake that holds a standing car: any value holds it


@dataclass(frozen=True)
class Targets:
    """What each equipped vehicle reacts to, (n,) each.

    Attributes:
        slot: of the target, -1 for none.
        gap: along the own path [m].
        speed, accel: along the own path [m/s], [m/s2].
        crossing: it crosses that path.
    """

    slot: Ints
    gap: Floats
    speed: Floats
    accel: Floats
    crossing: Bools


@dataclass(frozen=True)
class Target:
    """One vehicle's target at this step, for the books."""

    slot: int
    crossing: bool
    gap: float
    ttc: float
    ttc2: float
    closing_speed: float


class Fleet:
    """All equipped vehicles.

    Attributes:
        equipped: per slot.
        demand: per slot, the strategy's demand in the coming step.
        decel: per slot, mean deceleration by the AEB's brake in the coming step [m/s2].
    """

    def __init__(self, traffic: Traffic, paths: Paths, strategy: Strategy, sensor: Sensor, mu: float) -> None:
        self._traffic = traffic
        self._paths = paths
        self._strategy = strategy
        self._sensor = sensor
        self._mu = mu
        self._capacity = 0
        self._memory = strategy.init(0)
        self._brake = brake_init(strategy.brake, 0, traffic.dt)
        self.demand = Demand.nothing(0)
        self.equipped: Bools = np.zeros(0, np.bool_)
        self.decel: Floats = np.zeros(0)
        self._last_phase: Ints = np.zeros(0, np.int64)
        self._aimed: Floats = np.zeros(0)  # serial number of the last target
        self._aimed_gap: Floats = np.zeros(0)  # and its gap [m]
        self._hold: Floats = np.zeros(0)
        self._lead: Floats = np.zeros(0)  # serial number of the last lead seen
        self._lead_seen: Floats = np.zeros(0)  # for how long [s]
        self._crossing_seen: dict[tuple[float, float], float] = {}  # serials of ego and other -> for how long [s]
        self._targets: Targets | None = None
        self._rows: Ints = np.zeros(0, np.int64)

    def depart(self, slot: int, *, equipped: bool) -> None:
        """A vehicle enters."""
        self._fit()
        self.equipped[slot] = equipped
        self._reset(np.array([slot]))

    def leave(self, slot: int) -> None:
        """A vehicle is gone."""
        self.equipped[slot] = False
        self._reset(np.array([slot]))

    def step(self, turns: list[Turn], disabled: Bools) -> None:
        """From the state just observed to `demand` and `decel` for the coming step.

        Args:
            turns: vehicles near junctions and their paths.
            disabled: per slot, vehicles whose AEB is out of action (wrecks).
        """
        t, dt = self._traffic, self._traffic.dt
        self._fit()
        off = np.flatnonzero(self.equipped & disabled[: self._capacity])
        if len(off):
            self._reset(off)
        rows = np.flatnonzero(self.equipped & t.here & ~disabled)
        self.decel[:] = 0.0
        self.demand.phase[:] = Phase.NONE
        self.demand.decel[:] = 0.0
        targets = self._perceive(rows, turns)
        # The strategy only has work where there is a target, or something to end.
        unfinished = (self._last_phase[rows] > 0) | self._working(rows)
        busy = (targets.slot >= 0) | unfinished
        rows, targets = rows[busy], take(targets, busy)
        self._forget_others(rows, targets)
        self._rows, self._targets = rows, targets
        if not len(rows):
            return
        percept = Percept(
            valid=targets.slot >= 0,
            gap=targets.gap,
            ego_speed=t.speed[rows],
            ego_accel=t.accel[rows],
            target_speed=targets.speed,
            target_accel=targets.accel,
            mu=np.full(len(rows), self._mu),
        )
        memory, demand = self._strategy.step(take(self._memory, rows), percept, dt)
        put(self._memory, rows, memory)
        put(self.demand, rows, demand)
        self._last_phase[rows] = demand.phase
        self._apply_brake(rows, demand)

    def _working(self, rows: Ints) -> Bools:
        """Brakes that are on, hold a standing car, or have something on the way to them."""
        brake = take(self._brake, rows)
        result: Bools = (brake.decel > _RELEASED) | (brake.pipe > 0).any(1) | (self._hold[rows] > 0)
        return result

    def _forget_others(self, rows: Ints, targets: Targets) -> None:
        """A system that turns to another target farther away starts afresh: what it had latched was about the last one.

        Not so for another at the same place, such as the next of several e-bikes: there it goes on braking.
        """
        serial = np.where(targets.slot >= 0, self._traffic.serial[np.maximum(targets.slot, 0)], 0.0)
        changed = (serial != self._aimed[rows]) & (serial > 0) & (self._aimed[rows] > 0)
        other = rows[changed & (targets.gap > self._aimed_gap[rows] + _ELSEWHERE)]
        put(self._memory, other, self._strategy.init(len(other)))
        self._aimed[rows], self._aimed_gap[rows] = serial, targets.gap

    def _apply_brake(self, rows: Ints, demand: Demand) -> None:
        t, dt, params = self._traffic, self._traffic.dt, self._strategy.brake
        braking = (demand.decel > 0) | self._working(rows)
        rows, wanted = rows[braking], demand.decel[braking].copy()
        if not len(rows):
            return
        # Brought to a stop by its AEB, a car is held for a while; its driver then takes over.
        stopped = (t.speed[rows] <= 0) & (t.old_speed[rows] > 0) & (self._brake.decel[rows] > _RELEASED)
        self._hold[rows] = np.where(stopped, params.hold, np.maximum(self._hold[rows] - dt, 0.0))
        wanted = np.where(self._hold[rows] > 0, np.maximum(wanted, _HOLDING), wanted)
        brake, decel = brake_step(
            params, take(self._brake, rows), demand=wanted, mu=np.full(len(rows), self._mu), dt=dt
        )
        put(self._brake, rows, brake)
        decel = np.where(t.speed[rows] > 0, decel, np.where(self._hold[rows] > 0, _HOLDING, 0.0))
        self.decel[rows] = np.where(decel > _RELEASED, decel, 0.0)
        idle = rows[(self.decel[rows] == 0) & (wanted == 0) & ~(self._brake.pipe[rows] > 0).any(1)]
        if len(idle):
            put(self._brake, idle, brake_init(params, len(idle), dt))

    def active(self) -> list[tuple[int, Target | None]]:
        """Slots whose AEB warns or brakes in the coming step, with their targets."""
        if self._targets is None or not len(self._rows):
            return []
        t, rows, targets = self._traffic, self._rows, self._targets
        on = np.flatnonzero((self.demand.phase[rows] > Phase.NONE) | (self.decel[rows] > 0))
        if not len(on):
            return []
        slots = rows[on]
        gap, closing = targets.gap[on], t.speed[slots] - targets.speed[on]
        first = ttc(gap=gap, closing_speed=closing)
        second = ttc2(gap=gap, closing_speed=closing, closing_accel=t.accel[slots] - targets.accel[on])
        return [
            (
                int(slot),
                Target(
                    int(targets.slot[k]), bool(targets.crossing[k]), float(gap[i]), float(first[i]), float(second[i]),
                    float(closing[i]),
                )
                if targets.slot[k] >= 0
                else None,
            )
            for i, (slot, k) in enumerate(zip(slots, on, strict=True))
        ]  # fmt: skip

    def _perceive(self, rows: Ints, turns: list[Turn]) -> Targets:
        """The nearest confirmed target of each."""
        t = self._traffic
        moving = t.speed[rows] > 0
        lead, gap = np.full(len(rows), -1, np.int64), np.full(len(rows), np.inf)
        lead[moving], gap[moving] = self._leads(rows[moving])
        found = np.maximum(lead, 0)
        along = np.cos(t.heading[found] - t.heading[rows])
        targets = Targets(
            lead,
            gap,
            np.where(lead >= 0, t.speed[found] * along, 0.0),
            np.where(lead >= 0, t.accel[found] * along, 0.0),
            np.zeros(len(rows), np.bool_),
        )
        for slot, (other, distance) in self._crossings(rows, turns).items():
            k = int(np.searchsorted(rows, slot))
            if distance < targets.gap[k]:
                targets.slot[k], targets.gap[k], targets.crossing[k] = other, distance, True
                targets.speed[k] = targets.accel[k] = 0.0
        return targets

    def _leads(self, rows: Ints) -> tuple[Ints, Floats]:
        """Confirmed leads: slots (-1 for none) and gaps [m]."""
        t = self._traffic
        lead, gap = leaders(t, rows, self._sensor.reach)
        k = np.flatnonzero(lead >= 0)
        ego, other = rows[k], lead[k]
        seen = np.zeros(len(rows), np.bool_)
        seen[k] = sees_lead(
            self._sensor,
            x=t.x[ego],
            y=t.y[ego],
            heading=t.heading[ego],
            gap=gap[k],
            rear_x=t.x[other] - t.length[other] * np.cos(t.heading[other]),
            rear_y=t.y[other] - t.length[other] * np.sin(t.heading[other]),
            lead_heading=t.heading[other],
        )
        serial = np.where(seen, t.serial[np.maximum(lead, 0)], 0.0)
        same = (serial > 0) & (serial == self._lead[rows])
        self._lead_seen[rows] = np.where(same, self._lead_seen[rows] + t.dt, 0.0)
        self._lead[rows] = serial
        confirmed = seen & (self._lead_seen[rows] >= self._sensor.confirm - t.dt / 2)
        return np.where(confirmed, lead, -1), np.where(confirmed, gap, np.inf)

    def _crossings(self, rows: Ints, turns: list[Turn]) -> dict[int, tuple[int, float]]:
        """Confirmed crossing targets: ego slot -> (other slot, distance along the own path to the crossing [m])."""
        t = self._traffic
        before, self._crossing_seen = self._crossing_seen, {}
        by_junction: dict[str, list[Turn]] = {}
        for turn in turns:
            by_junction.setdefault(turn.path.junction, []).append(turn)
        pairs, zones = [], []
        moving = set(rows[t.speed[rows] > 0].tolist())
        for group in by_junction.values():
            for own in group:
                if own.slot not in moving:
                    continue
                for other in group:
                    zone = self._paths.zone(own, other)
                    if zone is not None and own.at < zone.own_to and other.slot != own.slot:
                        pairs.append((own.slot, other.slot))
                        zones.append(
                            (
                                zone.own_from - own.at,
                                zone.own_to - own.at,
                                zone.other_from - other.at,
                                zone.other_to - other.at,
                            )
                        )
        if not pairs:
            return {}
        ego, foe = np.array(pairs).T
        to_zone, through, foe_to_zone, foe_through = np.array(zones).T
        serials = list(zip(t.serial[ego].tolist(), t.serial[foe].tolist(), strict=True))
        braking = self._last_phase[ego] >= Phase.PARTIAL_BRAKE
        centre = t.length[foe] / 2
        seen, _ = covered(
            self._sensor,
            x=t.x[ego],
            y=t.y[ego],
            heading=t.heading[ego],
            target_x=t.x[foe] - np.cos(t.heading[foe]) * centre,
            target_y=t.y[foe] - np.sin(t.heading[foe]) * centre,
        )
        conflict = seen & conflicting(
            Approach(
                to_zone=to_zone,
                through_zone=through,
                speed=t.speed[ego],
                length=t.length[ego],
                other_to_zone=foe_to_zone,
                other_through_zone=foe_through,
                other_speed=t.speed[foe],
                other_accel=t.accel[foe],
                other_length=t.length[foe],
                locked=braking & np.array([s in before for s in serials]),
            )
        )
        result: dict[int, tuple[int, float]] = {}
        for k in np.flatnonzero(conflict).tolist():
            since = self._crossing_seen[serials[k]] = before.get(serials[k], -t.dt) + t.dt
            slot, gap = int(ego[k]), max(float(to_zone[k]), 0.0)
            if since >= self._sensor.confirm - t.dt / 2 and (slot not in result or gap < result[slot][1]):
                result[slot] = int(foe[k]), gap
        return result

    def _reset(self, rows: Ints) -> None:
        n = len(rows)
        put(self._memory, rows, self._strategy.init(n))
        put(self._brake, rows, brake_init(self._strategy.brake, n, self._traffic.dt))
        for array in (
            self._aimed,
            self._aimed_gap,
            self._hold,
            self._lead,
            self._lead_seen,
            self._last_phase,
            self.decel,
        ):
            array[rows] = 0

    def _fit(self) -> None:
        n = self._traffic.capacity
        if n == self._capacity:
            return
        for name in ("equipped", "decel", "_aimed", "_aimed_gap", "_hold", "_lead", "_lead_seen", "_last_phase"):
            setattr(self, name, fitted(getattr(self, name), n))
        grown_memory, grown_brake, grown_demand = (
            self._strategy.init(n), brake_init(self._strategy.brake, n, self._traffic.dt), Demand.nothing(n),
        )  # fmt: skip
        old = np.arange(self._capacity)
        put(grown_memory, old, self._memory)
        put(grown_brake, old, self._brake)
        put(grown_demand, old, self.demand)
        self._memory, self._brake, self.demand = grown_memory, grown_brake, grown_demand
        self._capacity = n
