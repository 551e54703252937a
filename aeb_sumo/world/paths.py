"""Where vehicles mean to go: their planned paths through the next junction, and where these cross."""

from dataclasses import dataclass
from typing import Any

import libsumo
import numpy as np

from aeb_sumo.compiled import kernel
from aeb_sumo.perception.crossing import crossing_zone
from aeb_sumo.soa import Bools, Floats, Ints, fitted
from aeb_sumo.world.network import Network
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.routes import SPACING, Path, Routes

__all__ = ["Crossings", "Paths", "Turns"]

_BEFORE = 60.0  # m before a junction at which a vehicle's path through it begins to matter, our assumption
_BEHIND = 2.0  # m behind a junction that a vehicle's tail has to be before it looks to the next one


@dataclass(frozen=True)
class Turns:
    """Vehicles near junctions in which others cross their paths, (n,) each.

    Attributes:
        slot: of the vehicle.
        at: distance of its front bumper along its path [m].
        user: number of its path and width, an index into `Paths.users`.
    """

    slot: Ints
    at: Floats
    user: Ints


@dataclass(frozen=True)
class Crossings:
    """Ordered pairs of vehicles near the same junction whose planned paths cross, (k,) each; every pair stands twice.

    Attributes:
        ego, other: slots.
        zone: (k, 4) from the front bumpers along the paths to the crossing: the ego's to where it begins and ends, the
            other's to where it begins and ends [m]; negative behind it.
    """

    ego: Ints
    other: Ints
    zone: Floats


_NONE = Crossings(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros((0, 4)))

# What is known of the way of the vehicle in a slot, positions as distances along its path [m].
_WAY = np.dtype(
    [
        ("due", "i8"),  # step in which it has to be asked for again
        ("planned", "?"),  # it has a path, to which all below belongs
        ("crossed", "?"),  # as in `Path`
        ("user", "i8"),  # as in `Turns`, -1 for not known yet
        ("start", "f8"),  # where its lane begins
        ("near", "f8"),  # where it begins to be near the junction
        ("behind", "f8"),  # where the lane behind the junction begins
        ("out", "f8"),  # how far it has to be along its lane for its tail to be out of the junction [m]
        ("turns", "?"),  # it is in `turns`
        ("at", "f8"),  # where it is, if so
    ],
    align=True,
)


class Paths:
    """Planned paths of vehicles, followed lane by lane.

    Attributes:
        users: every path in use and half the width of the vehicle on it [m]; the ends of `Turns.user`.
        turns, crossings: of the last step.
    """

    def __init__(self, traffic: Traffic, network: Network) -> None:
        self._traffic = traffic
        self._network = network
        self._routes = Routes(network)
        self._current: list[tuple[str, Path | None]] = []  # per slot, lane and path
        self._ways = np.zeros(0, _WAY)  # per slot
        self._numbers: dict[tuple[Path, float], int] = {}
        self.users: list[tuple[Path, float]] = []
        self._junctions: dict[str, int] = {}
        self._junction_of: Ints = np.zeros(0, np.int64)  # per user
        self._rank: Ints = np.zeros(0, np.int64)  # per user, its number among those at its junction
        # Where the paths of two users cross: the row in zones, by the one and the rank of the other, -1 for not known
        # yet; and the zones, nan where they do not.
        self._rows: Ints = np.full((64, 16), -1, np.int64)
        self._zones: Floats = np.zeros((0, 4))
        none = np.zeros(0, np.int64)
        self.turns = Turns(none, np.zeros(0), none)
        self.crossings = _NONE
        self._pairs = none, none

    def step(self) -> None:
        """From the traffic just observed to `turns` and `crossings`; those in turns are followed."""
        self.turns = self._near_junctions()
        if not len(self.turns.slot):
            self.crossings, self._pairs = _NONE, (_NONE.ego, _NONE.ego)
            return
        self._traffic.follow(self.turns.slot)
        i, j = self._pairs = _at_the_same(self._junction_of[self.turns.user])
        slot, at, user = self.turns.slot, self.turns.at, self.turns.user
        ego, other, zone, unknown = _cross(i, j, slot, at, user, self._rank, self._rows, self._zones)
        if unknown:
            self._learn(list(dict.fromkeys(unknown)))
            ego, other, zone, _ = _cross(i, j, slot, at, user, self._rank, self._rows, self._zones)
        self.crossings = Crossings(ego, other, zone)

    def pairs(self) -> tuple[Ints, Ints]:
        """All ordered pairs of `turns` at the same junction: (k,) and (k,) rows."""
        return self._pairs

    def ahead(self, slot: int, reach: float, spacing: float) -> Floats:
        """(n, 2) points `spacing` [m] apart that the front bumper of a vehicle present means to pass, from where it is.

        As far as `reach` [m], or to the end of the lane behind the next junction.
        """
        t = self._traffic
        vehicle = t.ids[slot]
        lane, at = libsumo.vehicle.getLaneID(vehicle), libsumo.vehicle.getLanePosition(vehicle)
        if lane != self._current[slot][0]:
            self._change(slot, lane)
        path = self._current[slot][1]
        line, along = self._routes.line(lane, path)
        where = np.arange(at, min(at + reach, along[-1]) + 1e-9, spacing)
        points = np.column_stack([np.interp(where, along, line[:, k]) for k in (0, 1)])
        # Who drives beside the middle of his lane goes on doing so.
        result: Floats = points + (np.array([t.x[slot], t.y[slot]]) - points[:1])
        return result

    def _near_junctions(self) -> Turns:
        """Vehicles from 60 m before a junction until their tail is out of it, if others cross there."""
        t, last = self._traffic, self.turns.slot
        if len(self._ways) < t.capacity:
            self._current += [("", None)] * (t.capacity - len(self._ways))
            self._ways = fitted(self._ways, t.capacity)
        for slot, _ in t.left:
            self._current[slot] = "", None
        if len(last):
            t.follow(last[t.here[last] & ~t.fresh[last]])
        ways, ids = self._ways, t.ids
        slots = _to_ask(ways, t.step, t.here & t.wheeled, t.fresh, t.speed, t.old_speed)
        if len(slots):
            lane_of, position_of, positions = libsumo.vehicle.getLaneID, libsumo.vehicle.getLanePosition, []
            current = self._current
            for slot in slots.tolist():
                vehicle = ids[slot]
                lane = lane_of(vehicle)
                if lane != current[slot][0]:
                    self._change(slot, lane)
                positions.append(position_of(vehicle))
            for slot, position in _look(ways, slots, np.array(positions), t.step, t.fastest, t.dt):
                self._look_closer(slot, position)
        slots = ways["turns"].nonzero()[0]
        return Turns(slots, ways["at"][slots], ways["user"][slots])

    def _look_closer(self, slot: int, position: float) -> None:
        """What `_look` leaves over: who has no path, needs the next one, or is on his for the first time."""
        t, way, (lane, path) = self._traffic, self._ways[slot], self._current[slot]
        if path is None:
            if lane and not lane.startswith(":"):
                left = self._network.length(lane) - position
                far = left if left <= _BEFORE and self._routes.ends_here(t.ids[slot]) else left - _BEFORE
                if far > 0:
                    way["due"] = t.step + int(far / (t.fastest[slot] * t.dt))
        elif way["turns"]:
            way["user"] = self._user(path, float(t.width[slot]) / 2)
        else:
            self._go_on(slot, lane, self._routes.onward(t.ids[slot], lane))

    def _change(self, slot: int, lane: str) -> None:
        """A vehicle has come to another lane."""
        path = self._current[slot][1]
        if path is None or lane not in path.starts:
            path = self._routes.onward(self._traffic.ids[slot], lane)
        self._go_on(slot, lane, path)

    def _go_on(self, slot: int, lane: str, path: Path | None) -> None:
        """The vehicle in a slot is on this lane and path now."""
        way, was = self._ways[slot], self._current[slot][1]
        self._current[slot] = lane, path
        way["planned"] = path is not None
        if path is not None:
            way["user"] = way["user"] if path is was else -1
            way["crossed"], way["start"], way["near"] = path.crossed, path.starts[lane], path.junction_at - _BEFORE
            way["behind"] = path.starts[path.to]
            way["out"] = self._traffic.length[slot] + _BEHIND if lane == path.to else np.inf

    def _user(self, path: Path, half_width: float) -> int:
        key = path, half_width
        if key not in self._numbers:
            self._numbers[key] = len(self.users)
            self.users.append(key)
            junction = self._junctions.setdefault(path.junction, len(self._junctions))
            rank = int((self._junction_of == junction).sum())
            self._junction_of = np.append(self._junction_of, junction)
            self._rank = np.append(self._rank, rank)
            have, need = self._rows.shape, (len(self.users), rank + 1)
            if need[0] > have[0] or need[1] > have[1]:  # twice as many, or a city would be copied for each of them
                more = [(0, h if n > h else 0) for n, h in zip(need, have, strict=True)]
                self._rows = np.pad(self._rows, more, constant_values=-1)
        return self._numbers[key]

    def _learn(self, pairs: list[tuple[int, int]]) -> None:
        """Find out where the paths of users cross that have not met before."""
        for row, (own, other) in enumerate(pairs, len(self._zones)):
            self._rows[own, self._rank[other]] = row
        self._zones = np.vstack([self._zones, [self._zone(own, other) for own, other in pairs]])

    def _zone(self, own: int, other: int) -> tuple[float, float, float, float]:
        (path, half), (crossed, other_half) = self.users[own], self.users[other]
        zone = crossing_zone(
            *(path.points, path.heading, crossed.points, crossed.heading), width=half + other_half, spacing=SPACING
        )
        if zone is None:
            return np.nan, np.nan, np.nan, np.nan
        return (
            path.origin + zone.own_from,
            path.origin + zone.own_to,
            crossed.origin + zone.other_from,
            crossed.origin + zone.other_to,
        )


@kernel
def _to_ask(ways: Any, step: int, here: Bools, fresh: Bools, speed: Floats, old_speed: Floats) -> Ints:
    """Slots of vehicles that may be near a junction; who was, and has not moved since, still is in `turns`."""
    slots = np.empty(len(here), np.int64)
    n = 0
    for slot in range(len(here)):
        way = ways[slot]
        if fresh[slot]:
            way.due = 0
        way.turns = way.turns and here[slot] and not fresh[slot] and speed[slot] == 0 and old_speed[slot] == 0
        # Who was far from any junction cannot be near one yet.
        if here[slot] and way.due <= step and not way.turns:
            slots[n] = slot
            n += 1
    return slots[:n]


@kernel
def _look(ways: Any, slots: Ints, positions: Floats, step: int, fastest: Floats, dt: float) -> list[tuple[int, float]]:
    """Who of these, so far along their lanes [m], is in `turns`, and when the others may be; whom it cannot tell of."""
    rest = []
    for k in range(len(slots)):
        slot, way = slots[k], ways[slots[k]]
        at, far = way.start + positions[k], 0.0
        if not way.planned or positions[k] > way.out:
            rest.append((slot, positions[k]))
        elif at < way.near:
            far = way.near - at
        elif not way.crossed:
            far = way.behind - at
        else:
            way.turns, way.at = True, at
            if way.user < 0:
                rest.append((slot, positions[k]))
        if far > 0:
            way.due = step + int(far / (fastest[slot] * dt))
    return rest


@kernel
def _at_the_same(junction: Ints) -> tuple[Ints, Ints]:
    """All ordered pairs of rows with the same junction, (k,) each, junction by junction."""
    order = np.argsort(junction, kind="mergesort")
    n = begin = 0
    for a in range(len(order)):
        if junction[order[a]] != junction[order[begin]]:
            begin = a
        n += 2 * (a - begin)
    first, second = np.empty(n, np.int64), np.empty(n, np.int64)
    n = begin = 0
    for a in range(len(order)):
        if junction[order[a]] != junction[order[begin]]:
            begin = a
        for b in range(begin, len(order)):
            if junction[order[b]] != junction[order[a]]:
                break
            if a != b:
                first[n], second[n] = order[a], order[b]
                n += 1
    return first, second


@kernel
def _cross(
    first: Ints, second: Ints, slot: Ints, at: Floats, user: Ints, rank: Ints, rows: Ints, zones: Floats
) -> tuple[Ints, Ints, Floats, list[tuple[int, int]]]:
    """Of pairs (k,) of rows of `Turns` those whose paths cross, as in `Crossings`, and users who are not known to."""
    ego, other, zone = np.empty(len(first), np.int64), np.empty(len(first), np.int64), np.empty((len(first), 4))
    n, unknown = 0, []
    for k in range(len(first)):
        i, j = first[k], second[k]
        row = rows[user[i], rank[user[j]]]
        if row < 0:
            unknown.append((user[i], user[j]))
        elif np.isfinite(zones[row, 0]):
            ego[n], other[n] = slot[i], slot[j]
            zone[n, 0], zone[n, 1] = zones[row, 0] - at[i], zones[row, 1] - at[i]
            zone[n, 2], zone[n, 3] = zones[row, 2] - at[j], zones[row, 3] - at[j]
            n += 1
    return ego[:n], other[:n], zone[:n], unknown
