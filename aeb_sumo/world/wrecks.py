"""Crashes of a run: found, told from artefacts of the network, recorded once each, and left to block the road."""

from dataclasses import dataclass, field
from itertools import product

import libsumo
import numpy as np

from aeb_sumo.soa import Bools, Floats, Ints, fitted
from aeb_sumo.world.contact import Impact, impact, touching
from aeb_sumo.world.kinds import VClasses
from aeb_sumo.world.network import Network
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.typology import typology
from aeb_sumo.world.walkers import PREFIX, fell

__all__ = ["Crash", "Wrecks", "pair_of"]

_SLIDING = 6.0  # m/s2, deceleration of a wreck, our assumption
_LEFT = frozenset("lL")
_STANDS = 0.1  # m/s, a slower vehicle runs nobody down, our assumption


@dataclass(frozen=True)
class Crash:
    """One crash: the first contact of a pair of vehicles.

    Attributes:
        impact: instant, point, speeds.
        kind: `rear_end`, `left_turn_across_path` (one turns left in front of oncoming traffic), `crossing`, `head_on`,
            `side`, or `pedestrian` (a moving vehicle and a person on foot).
        typology: as `aeb_sumo.world.typology` has it; empty unless a car and a two-wheeler crash.
        striker, struck: their names in `Traffic.ids`.
        lane: of the struck vehicle; of the only one, if one is on foot.
        secondary: one of them had crashed before.
    """

    impact: Impact
    kind: str
    typology: str
    striker: str
    struck: str
    lane: str
    secondary: bool


@dataclass
class _Place:
    """Where a vehicle's body is: its lanes, and the turn it makes in a junction, if any."""

    lanes: list[str]
    direction: str = ""
    approach: float | None = None  # heading on the lane before the junction [rad]


@dataclass
class Wrecks:
    """Book of crashes.

    A contact counts when the bodies approach each other and their lanes have to do with each other: the same lane,
    consecutive ones, or conflicting ones in a junction. SUMO's vehicles never leave their lanes, so boxes that touch
    across unrelated lanes (opposite directions drawn too close, the tail of a bus in a curve) tell of the network's
    drawing and not of a crash; they are counted in `dismissed`.

    Attributes:
        traffic, network: the world.
        sublane: vehicles may be beside the centre of their lane, so that neighbouring lanes have to do with each other.
        blockage: how long wrecks stand before they leave [s].
        dismissed: pairs that touched without being a crash.
        reported: pairs that SUMO's own collision check reported -> first time [s].
        removed: wrecks that have been cleared away.
        wrecked: per slot.
        speed: per slot, of a wreck [m/s].
    """

    traffic: Traffic
    network: Network
    sublane: bool
    blockage: float
    dismissed: set[tuple[str, str]] = field(default_factory=set)
    reported: dict[tuple[str, str], float] = field(default_factory=dict)
    crashed: set[tuple[str, str]] = field(default_factory=set)
    removed: set[str] = field(default_factory=set)
    wrecked: Bools = field(default_factory=lambda: np.zeros(0, np.bool_))
    speed: Floats = field(default_factory=lambda: np.zeros(0))
    _pile: dict[str, set[str]] = field(default_factory=dict)  # wreck -> all wrecks it has touched, directly or not
    _until: dict[str, float] = field(default_factory=dict)
    _touched: dict[tuple[str, str], float] = field(default_factory=dict)  # vehicle and walker -> last time [s]

    def step(self, time: float, *, apart: bool = False) -> list[Crash]:
        """The crashes of the step that ended at `time` [s].

        Args:
            time: now [s].
            apart: nobody who is followed is near enough to another for a contact, unless SUMO reports one.
        """
        t = self.traffic
        self.wrecked, self.speed = fitted(self.wrecked, t.capacity), fitted(self.speed, t.capacity)
        for slot, vehicle in t.left:
            self.wrecked[slot] = False
            self._until.pop(vehicle, None)
            self._pile.pop(vehicle, None)
        new: list[Crash] = []
        if not self._hear(time) and apart:
            self._slow_down()
            return new
        pairs, instants = touching(t, (t.followed & t.here & t.wheeled).nonzero()[0])
        for k in np.argsort(instants, kind="stable"):
            # Wrecks go on touching for as long as they stand.
            if pair_of(*(t.ids[slot] for slot in pairs[k])) in self.crashed:
                continue
            crash = self._judge(impact(t, pairs[k], float(instants[k]), time))
            if crash is not None:
                new.append(crash)
        self._slow_down()
        return new

    @property
    def sliding(self) -> Ints:
        """Slots of wrecks that do not stand yet."""
        return (self.wrecked & (self.speed > 0)).nonzero()[0]

    def _slow_down(self) -> None:
        if self._until:
            self.speed = np.maximum(self.speed - _SLIDING * self.traffic.dt, 0.0)

    def _hear(self, time: float) -> bool:
        """Whether SUMO reports something new: the net below the own search, for whom nobody follows yet."""
        t, collisions, new = self.traffic, libsumo.simulation.getCollisions(), False
        for collision in collisions:
            one = self._name(collision.collider, collision.colliderType)
            other = self._name(collision.victim, collision.victimType)
            if one and other:
                self.reported.setdefault(pair_of(one, other), time)
                new |= pair_of(one, other) not in self.crashed
                t.follow(np.array([t.slot[name] for name in (one, other) if name in t.slot]))
        return new

    def _name(self, reported: str, vtype: str) -> str:
        """Name in `Traffic.ids` of whom SUMO reports, who may be a person; empty for nobody there."""
        t = self.traffic
        walks = PREFIX + reported in {t.ids[slot] for slot in t.walkers.tolist()}
        drives = reported in t.slot
        if walks and drives:
            walks = t.vtype[t.slot[reported]] != vtype
        return PREFIX + reported if walks else reported if drives else ""

    def _judge(self, hit: Impact) -> Crash | None:
        t = self.traffic
        striker, struck = t.ids[hit.striker], t.ids[hit.struck]
        pair = pair_of(striker, struck)
        if "pedestrian" in (t.vclass[hit.striker], t.vclass[hit.struck]):
            return self._run_down(hit)
        if hit.approach <= 0:
            return None
        # Who parks is beside the road, and on no lane.
        parked = any(libsumo.vehicle.isStoppedParking(v) for v in (striker, struck))
        places = [] if parked else [self._place(v) for v in (striker, struck)]
        if parked or not self._related(places[0].lanes, places[1].lanes):
            self.dismissed.add(pair)
            return None
        secondary = bool(self.wrecked[hit.striker] or self.wrecked[hit.struck])
        self.crashed.add(pair)
        for slot, vehicle, speed in ((hit.striker, striker, hit.striker_speed), (hit.struck, struck, hit.struck_speed)):
            self.speed[slot] = self.speed[slot] if self.wrecked[slot] else speed
            self.wrecked[slot] = True
            self._until[vehicle] = hit.time + self.blockage
        self._slide_together(pair)
        headings = [
            p.approach if p.approach is not None else float(t.heading[s])
            for p, s in zip(places, (hit.striker, hit.struck), strict=True)
        ]
        kind = self._kind(hit, places, headings)
        return Crash(
            hit, kind, self._typology(hit, places, headings, kind), striker, struck, places[1].lanes[0], secondary
        )

    def _run_down(self, hit: Impact) -> Crash | None:
        """A vehicle and a person on foot: a crash wherever they touch, if the vehicle moves when they begin to.

        SUMO's persons walk through vehicles that stand in their way, and are inside them when these move on.
        The person is taken away at once; the vehicle, hardly slowed by him, slides to a stop and stands like any wreck.
        """
        t = self.traffic
        slot, speed, walker = hit.striker, hit.striker_speed, hit.struck
        if t.vclass[slot] == "pedestrian":
            slot, speed, walker = hit.struck, hit.struck_speed, hit.striker
        vehicle, striker, struck = t.ids[slot], t.ids[hit.striker], t.ids[hit.struck]
        pair = pair_of(striker, struck)
        self._touched = {p: when for p, when in self._touched.items() if hit.time - when < 10 * t.dt}
        touched, self._touched[pair] = self._touched.get(pair, -np.inf), hit.time
        if hit.approach <= 0 or speed <= _STANDS or hit.time - touched < 2 * t.dt:
            return None
        secondary = bool(self.wrecked[slot])
        self.crashed.add(pair)
        self.speed[slot] = self.speed[slot] if secondary else speed
        self.wrecked[slot] = True
        self._until[vehicle] = hit.time + self.blockage
        fell(t.ids[walker])
        return Crash(hit, "pedestrian", "", striker, struck, libsumo.vehicle.getLaneID(vehicle), secondary)

    def _slide_together(self, pair: tuple[str, str]) -> None:
        """All wrecks of a pile-up go on with their common momentum: none passes through another."""
        t = self.traffic
        self._pile[pair[0]] = self._pile[pair[1]] = {
            vehicle for one in pair for vehicle in self._pile.get(one, {one}) if vehicle in t.slot
        }
        for vehicle in self._pile[pair[0]]:
            self._pile[vehicle] = self._pile[pair[0]]
        slots = np.array(sorted(t.slot[vehicle] for vehicle in self._pile[pair[0]]))
        heading = np.column_stack([np.cos(t.heading[slots]), np.sin(t.heading[slots])])
        mass = t.mass[slots]
        common = (mass * self.speed[slots]) @ heading / mass.sum()
        # Who was hit at a scheduled stop stays there: SUMO moves nobody from one.
        held = np.array([libsumo.vehicle.isStopped(t.ids[slot]) for slot in slots.tolist()], np.bool_)
        self.speed[slots] = np.where(held, 0.0, np.maximum(heading @ common, 0.0))

    def _typology(self, hit: Impact, places: list[_Place], headings: list[float], kind: str) -> str:
        vclass = [self.traffic.vclass[slot] for slot in (hit.striker, hit.struck)]
        for car, rider in ((0, 1), (1, 0)):
            if vclass[car] in VClasses.CARS and vclass[rider] in VClasses.RIDERS:
                return typology(
                    car=headings[car],
                    rider=headings[rider],
                    turn=places[car].direction,
                    rear_end=kind == "rear_end" and car == 0,
                )
        return ""

    def _kind(self, hit: Impact, places: list[_Place], headings: list[float]) -> str:
        opposed = np.cos(headings[0] - headings[1]) < -0.5  # more than 120 degrees apart before the junction
        if opposed and any(p.direction in _LEFT and p.direction for p in places):
            return "left_turn_across_path"
        if hit.angle < np.pi / 4:
            return "rear_end" if hit.at_rear else "side"
        return "head_on" if hit.angle > 3 * np.pi / 4 else "crossing"

    def _place(self, vehicle: str) -> _Place:
        """Lanes under the vehicle's body, that of its front first."""
        get, net = libsumo.vehicle, self.network
        lane = get.getLaneID(vehicle)
        place = _Place([lane])
        edges, at = get.getRoute(vehicle), get.getRouteIndex(vehicle)
        behind = get.getLength(vehicle) - get.getLanePosition(vehicle)
        inside = lane.startswith(":")
        if not inside and behind <= 0:
            return place
        # The edge before the junction: SUMO keeps it as the current one until the vehicle has left the junction.
        before = edges[at] if inside else edges[at - 1] if at > 0 else ""
        for approach in net.lanes(before) if before else []:
            for link in net.links(approach):
                if lane in link.via or (not inside and link.to == lane):
                    upto = link.via.index(lane) if inside else len(link.via)
                    place.lanes += [v for v in link.via[:upto] if v not in place.lanes]
                    if approach not in place.lanes:
                        place.lanes.append(approach)
                    place.direction = link.direction
                    (x0, y0), (x1, y1) = net.shape(approach)[-2:]
                    place.approach = float(np.arctan2(y1 - y0, x1 - x0))
        return place

    def _related(self, a: list[str], b: list[str]) -> bool:
        net = self.network
        if set(a) & set(b):
            return True
        for one, two in product(a, b):
            if two in net.foes(one) or one in net.foes(two):
                return True
            if any(two == k.to or two in k.via for k in net.links(one)):
                return True
            if any(one == k.to or one in k.via for k in net.links(two)):
                return True
            if self.sublane and net.edge(one) == net.edge(two):
                return True
        return False

    def clear(self, time: float) -> None:
        """Take away the wrecks whose time has come; the last thing in a step."""
        for vehicle in [v for v, until in self._until.items() if until <= time]:
            del self._until[vehicle]
            if vehicle in self.traffic.slot:
                self.removed.add(vehicle)
                libsumo.vehicle.remove(vehicle)
                self.traffic.taken_away(vehicle)


def pair_of(a: str, b: str) -> tuple[str, str]:
    """Two names in alphabetical order."""
    return (a, b) if a <= b else (b, a)
