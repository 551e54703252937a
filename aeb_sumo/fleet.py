"""The arrays of all equipped vehicles, and the pipeline over them: perception -> strategy -> brake."""

from dataclasses import dataclass

import numpy as np

from aeb_sumo.brakes import Brakes
from aeb_sumo.candidates import Candidates
from aeb_sumo.compiled import kernel
from aeb_sumo.criticality import ttc, ttc2
from aeb_sumo.grip import Grip
from aeb_sumo.lookout import Lookout
from aeb_sumo.perception.suites import Suite
from aeb_sumo.soa import Bools, Floats, Ints, fitted, joined, mask, put, take
from aeb_sumo.strategies.base import Demand, Percept, Phase, Strategy
from aeb_sumo.targets import Targets
from aeb_sumo.world.footpaths import Footpaths
from aeb_sumo.world.friction import Friction
from aeb_sumo.world.leads import Leads
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.paths import Paths
from aeb_sumo.world.sightlines import Sightlines

__all__ = ["Fleet", "Target"]

_ELSEWHERE = 2.0  # m, another target farther away than the last by more than this is another matter, our assumption


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
        grip: what they know of the road's friction.
        at_work: slots of those whose system warns or brakes, or whose brake is not off yet.
    """

    def __init__(
        self,
        traffic: Traffic,
        leads: Leads,
        paths: Paths,
        footpaths: Footpaths,
        sightlines: Sightlines,
        friction: Friction,
        strategy: Strategy,
        suite: Suite,
        *,
        sublane: bool,
        seed: int,
    ) -> None:
        self._traffic = traffic
        self._friction = friction
        self._strategy = strategy
        candidates = Candidates(traffic, leads, paths, footpaths, sightlines, suite, strategy.gaze)
        self._lookout = Lookout(traffic, candidates, suite, strategy.gaze, sublane=sublane, seed=seed)
        self.grip = Grip(
            traffic, friction, estimates=strategy.estimates_friction, prior=strategy.friction_prior, seed=seed
        )
        self._capacity = 0
        self._memory = strategy.init(0)
        self._brakes = Brakes(traffic, friction, strategy.brake)
        self.demand = Demand.nothing(0)
        self._held = Demand.nothing(0)  # the last demand of each, until its system works again
        self._next: Floats = np.zeros(0)  # when that is [s]
        self._begun: Floats = np.zeros(0)  # and when it began to work [s]
        self.equipped: Bools = np.zeros(0, np.bool_)
        self._off: Bools = np.zeros(0, np.bool_)  # disabled, and reset since
        self.decel: Floats = np.zeros(0)
        self._last_phase: Ints = np.zeros(0, np.int64)
        self._aimed: Floats = np.zeros(0)  # serial number of the last target
        self._aimed_gap: Floats = np.zeros(0)  # and its gap [m]
        self._targets: Targets | None = None
        self._rows: Ints = np.zeros(0, np.int64)
        self.at_work: Ints = np.zeros(0, np.int64)

    def depart(self, slot: int, time: float, *, equipped: bool) -> None:
        """A vehicle enters at `time` [s]."""
        self.fit()
        self.equipped[slot] = equipped
        self._reset(np.array([slot]))
        self._off[slot] = False
        self._begun[slot] = time
        if equipped:
            self.grip.depart(slot)

    def leave(self, slot: int) -> None:
        """A vehicle is gone; its state is that of nobody until the next one enters."""
        self.equipped[slot] = False
        self.decel[slot] = 0.0

    def step(self, time: float, disabled: Bools) -> None:
        """From the state just observed to `demand` and `decel` for the coming step.

        Args:
            time: now [s].
            disabled: per slot, vehicles whose AEB is out of action (wrecks).
        """
        t = self._traffic
        self.fit()
        rows, off = _at_work(self.equipped, disabled, self._off, t.here, t.followed_at, t.step)
        if len(off):
            self._reset(off)
        self.decel.fill(0.0)
        self.demand.phase.fill(Phase.NONE)
        self.demand.decel.fill(0.0)
        self.at_work = rows[:0]
        if not len(rows) and not self._lookout.remembers:
            self._rows, self._targets = rows, None
            return
        self.grip.step(rows)
        seeing, targets = self._lookout.step(rows, braking=self._last_phase >= Phase.PARTIAL_BRAKE, time=time)
        # The strategy only has work where there is a target, or something to end.
        unfinished = self._to_end(rows)
        unfinished = unfinished[~mask(seeing, t.capacity)[unfinished]] if len(unfinished) else unfinished
        rows = seeing
        if len(unfinished):
            rows = np.append(seeing, unfinished)
            order = np.argsort(rows)
            rows, targets = rows[order], take(joined(targets, Targets.none(len(unfinished))), order)
        self._rows, self._targets = rows, targets
        if not len(rows):
            return
        self._forget_others(rows, targets)
        self._act(rows, targets, time)
        self.at_work = self._to_end(rows)

    @property
    def busy(self) -> Ints:
        """Slots of the vehicles that have to be followed whatever they meet.

        Those with something to end, and all where friction is learnt from driving.
        """
        if self._strategy.estimates_friction:
            return (self.equipped & self._traffic.here).nonzero()[0]
        return self.at_work

    def _act(self, rows: Ints, targets: Targets, time: float) -> None:
        """From what is perceived to what the brakes do."""
        t = self._traffic
        percept = Percept(
            valid=targets.slot >= 0,
            gap=targets.gap,
            ego_speed=t.speed[rows],
            ego_accel=t.accel[rows],
            target_speed=targets.speed,
            target_accel=targets.accel,
            ahead=targets.ahead,
            left=targets.left,
            closing_ahead=targets.closing_ahead,
            closing_left=targets.closing_left,
            vulnerable=targets.vulnerable,
            mu=self.grip.known(rows),
        )
        demand = self._decide(rows, percept, time)
        put(self.demand, rows, demand)
        self._last_phase[rows] = demand.phase
        self._brakes.apply(rows, demand.decel, self.decel)

    def _decide(self, rows: Ints, percept: Percept, time: float) -> Demand:
        """What the strategy demands of these vehicles."""
        dt, cycle = self._traffic.dt, self._strategy.cycle
        if cycle <= dt:
            memory, demand = self._strategy.step(take(self._memory, rows), percept, dt)
            put(self._memory, rows, memory)
            return demand
        # A system that works more slowly than the simulation holds its demand meanwhile, unless its target is gone.
        due = (time >= self._next[rows] - dt / 2) | ~percept.valid
        now = rows[due]
        if len(now):
            memory, demand = self._strategy.step(take(self._memory, now), take(percept, due), cycle)
            put(self._memory, now, memory)
            put(self._held, now, demand)
            begun = self._begun[now]
            self._next[now] = begun + (np.floor((time - begun + dt / 2) / cycle) + 1) * cycle
        return take(self._held, rows)

    def _to_end(self, rows: Ints) -> Ints:
        """Those of the rows whose system does something, or whose brake is on or about to be."""
        return rows[(self._last_phase[rows] > 0) | self._brakes.working(rows)]

    def _forget_others(self, rows: Ints, targets: Targets) -> None:
        """A system that turns to another target farther away starts afresh: what it had latched was about the last one.

        Not so for another at the same place, such as the next of several e-bikes: there it goes on braking.
        """
        other = rows[_turned_away(rows, targets.slot, targets.gap, self._traffic.serial, self._aimed, self._aimed_gap)]
        if len(other):
            put(self._memory, other, self._strategy.init(len(other)))
            self._next[other] = 0.0

    def targets(self, slots: Ints) -> Targets:
        """What the vehicles in these slots react to in the coming step."""
        result = Targets.none(len(slots))
        if self._targets is not None:
            working, at = np.isin(slots, self._rows), np.searchsorted(self._rows, slots)
            put(result, working, take(self._targets, at[working]))
        return result

    def active(self) -> list[tuple[int, Target | None]]:
        """Slots whose AEB warns or brakes in the coming step, with their targets."""
        if self._targets is None or not len(self._rows):
            return []
        t, rows, targets = self._traffic, self._rows, self._targets
        on = ((self.demand.phase[rows] > Phase.NONE) | (self.decel[rows] > 0)).nonzero()[0]
        if not len(on):
            return []
        slots = rows[on]
        gap, closing = targets.gap[on], t.speed[slots] - targets.speed[on]
        first = ttc(gap=gap, closing_speed=closing)
        second = ttc2(gap=gap, closing_speed=closing, closing_accel=t.accel[slots] - targets.accel[on])
        return [
            (slot, Target(*what) if what[0] >= 0 else None)
            for slot, *what in zip(
                slots.tolist(),
                targets.slot[on].tolist(),
                targets.crossing[on].tolist(),
                gap.tolist(),
                first.tolist(),
                second.tolist(),
                closing.tolist(),
                strict=True,
            )
        ]

    def _reset(self, rows: Ints) -> None:
        n = len(rows)
        put(self._memory, rows, self._strategy.init(n))
        self._brakes.reset(rows)
        put(self._held, rows, Demand.nothing(n))
        for array in (self._aimed, self._aimed_gap, self._last_phase, self._next, self.decel):
            array[rows] = 0

    def fit(self) -> bool:
        """Make room for all slots; whether there was too little."""
        n = self._traffic.capacity
        if n == self._capacity:
            return False
        for name in ("equipped", "_off", "decel", "_aimed", "_aimed_gap", "_last_phase", "_next", "_begun"):
            setattr(self, name, fitted(getattr(self, name), n))
        old = np.arange(self._capacity)
        for name, grown in (
            ("_memory", self._strategy.init(n)),
            ("demand", Demand.nothing(n)),
            ("_held", Demand.nothing(n)),
        ):
            put(grown, old, getattr(self, name))
            setattr(self, name, grown)
        self._brakes.fit(n)
        self._capacity = n
        return True


@kernel
def _at_work(
    equipped: Bools, disabled: Bools, off: Bools, here: Bools, followed_at: Ints, step: int
) -> tuple[Ints, Ints]:
    """Slots of those whose system works and who are followed in this step, and of those that are newly `off`."""
    rows, newly = np.empty(len(equipped), np.int64), np.empty(len(equipped), np.int64)
    works, broken = 0, 0
    for slot in range(len(equipped)):
        if not equipped[slot]:
            continue
        if disabled[slot]:
            if not off[slot]:
                off[slot], newly[broken] = True, slot
                broken += 1
        elif here[slot] and followed_at[slot] == step:
            rows[works] = slot
            works += 1
    return rows[:works], newly[:broken]


@kernel
def _turned_away(rows: Ints, target: Ints, gap: Floats, serial: Floats, aimed: Floats, aimed_gap: Floats) -> Bools:
    """Which have another target than before, and farther away; `aimed` and `aimed_gap` are brought up to date."""
    result = np.empty(len(rows), np.bool_)
    for k in range(len(rows)):
        slot = rows[k]
        now = serial[target[k]] if target[k] >= 0 else 0.0
        other = now != aimed[slot] and now > 0 and aimed[slot] > 0
        result[k] = other and gap[k] > aimed_gap[slot] + _ELSEWHERE
        aimed[slot], aimed_gap[slot] = now, gap[k]
    return result
