"""Where vehicles mean to go: their planned paths through the next junction, and where these cross."""

from dataclasses import dataclass
from functools import cache

import libsumo
import numpy as np

from aeb_sumo.perception.crossing import crossing_zone
from aeb_sumo.soa import Floats, Ints, first_of_each, fitted
from aeb_sumo.world.network import Link, Network
from aeb_sumo.world.observe import Traffic

__all__ = ["Crossings", "Path", "Paths", "Turns"]

_SPACING = 0.5  # m between the points of a path
_BEFORE = 60.0  # m before a junction at which a vehicle's path through it begins to matter, our assumption
_TURNS = frozenset("lLrRt")
_BEHIND = 2.0  # m behind a junction that a vehicle's tail has to be before it looks to the next one


@dataclass(frozen=True, eq=False)
class Path:
    """A path from a lane through a junction.

    Attributes:
        points: (n, 2) along the lanes' centres from `origin` on, `_SPACING` apart [m].
        heading: (n,) direction there [rad].
        origin: distance along the path at which the points begin [m]: a little before the junction.
        starts: lane -> distance along the path at which it starts [m].
        to: the lane behind the junction.
        junction_at: distance at which the junction begins [m].
        junction: its id.
        crossed: other lanes cross it inside the junction.
        direction: SUMO's letter of the turn.
        approach: the edge before the junction.
        gives_way: who goes there has to give way to some: he turns, or comes from a minor road without a signal.
    """

    points: Floats
    heading: Floats
    origin: float
    starts: dict[str, float]
    to: str
    junction_at: float
    junction: str
    crossed: bool
    direction: str
    approach: str
    gives_way: bool


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


class Paths:
    """Planned paths of vehicles, followed lane by lane.

    Attributes:
        users: every path in use and half the width of the vehicle on it [m]; the ends of `Turns.user`.
        turns, crossings: of the last step.
    """

    def __init__(self, traffic: Traffic, network: Network) -> None:
        self._line = cache(self._line_from)
        self._traffic = traffic
        self._network = network
        self._known: dict[tuple[str, Link], Path] = {}
        self._current: dict[str, tuple[str, Path | None]] = {}  # vehicle -> (lane, path)
        self._numbers: dict[tuple[Path, float], int] = {}
        self.users: list[tuple[Path, float]] = []
        self._junctions: dict[str, int] = {}
        self._junction_of: list[int] = []  # per user
        self._due: Ints = np.zeros(0, np.int64)  # per slot, step in which its path has to be asked for again
        # Where the paths of two users cross: keys, rising, the last one beyond all others, and a row for each, nan
        # where they do not.
        self._keys: Ints = np.full(1, np.iinfo(np.int64).max)
        self._zones: Floats = np.full((1, 4), np.nan)
        none = np.zeros(0, np.int64)
        self.turns = Turns(none, np.zeros(0), none)
        self.crossings = _NONE

    def step(self) -> None:
        """From the traffic just observed to `turns` and `crossings`; those in turns are followed."""
        self.turns = self._near_junctions()
        if not len(self.turns.slot):
            self.crossings = _NONE
            return
        self._traffic.follow(self.turns.slot)
        i, j = self.pairs()
        zone = self._zones_of(self.turns.user[i], self.turns.user[j])
        crossed = np.isfinite(zone[:, 0]).nonzero()[0]
        i, j, zone = i[crossed], j[crossed], zone[crossed]
        slot, at = self.turns.slot, self.turns.at
        zone[:, :2] -= at[i, None]
        zone[:, 2:] -= at[j, None]
        self.crossings = Crossings(slot[i], slot[j], zone)

    def pairs(self) -> tuple[Ints, Ints]:
        """All ordered pairs of `turns` at the same junction: (k,) and (k,) rows."""
        junction = np.array([self._junction_of[u] for u in self.turns.user.tolist()], np.int64)
        order = np.argsort(junction, kind="stable")
        start = first_of_each(junction[order]).nonzero()[0]
        size = np.append(start[1:], len(order)) - start
        each = np.repeat(size, size)  # per row in order: how many there are at its junction
        first = np.repeat(np.arange(len(order)), each)
        before = np.repeat(np.cumsum(each) - each, each)
        second = np.repeat(np.repeat(start, size), each) + np.arange(len(first)) - before
        apart = first != second
        return order[first[apart]], order[second[apart]]

    def ahead(self, slot: int, reach: float, spacing: float) -> Floats:
        """(n, 2) points `spacing` [m] apart that the front bumper of a vehicle present means to pass, from where it is.

        As far as `reach` [m], or to the end of the lane behind the next junction.
        """
        t, vehicle = self._traffic, self._traffic.ids[slot]
        lane, path, at = self._follow(vehicle)
        line, along = self._line(lane, path)
        where = np.arange(at, min(at + reach, along[-1]) + 1e-9, spacing)
        points = np.column_stack([np.interp(where, along, line[:, k]) for k in (0, 1)])
        # Who drives beside the middle of his lane goes on doing so.
        result: Floats = points + (np.array([t.x[slot], t.y[slot]]) - points[:1])
        return result

    def _line_from(self, lane: str, path: Path | None) -> tuple[Floats, Floats]:
        """Centre line of a lane and those behind it on a path: (n, 2) points and (n,) distances along it [m]."""
        lanes = [lane] if path is None or lane not in path.starts else list(path.starts)
        line = np.vstack([self._network.shape(each) for each in lanes[lanes.index(lane) :]])
        line = line[np.concatenate([[True], np.hypot(*np.diff(line, axis=0).T) > 1e-6])]
        return line, np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])

    def _near_junctions(self) -> Turns:
        """Vehicles from 60 m before a junction until their tail is out of it, if others cross there."""
        t = self._traffic
        slots: list[int] = []
        positions: list[float] = []
        users: list[int] = []
        for _, vehicle in t.left:
            self._current.pop(vehicle, None)
        # Who was far from any junction cannot be near one yet.
        self._due = fitted(self._due, t.capacity)
        if t.departed or t.fresh.any():
            self._due[t.fresh] = 0
        reach = t.fastest * t.dt
        stood = self._stood()
        for slot in (t.here & t.wheeled & (self._due <= t.step)).nonzero()[0].tolist():
            if slot in stood:
                at, user = stood[slot]
                slots.append(slot)
                positions.append(at)
                users.append(user)
                continue
            vehicle = t.ids[slot]
            lane, path, position = self._follow(vehicle)
            far = 0.0
            if path is None:
                if lane and not lane.startswith(":"):
                    left = self._network.length(lane) - position
                    far = left if left <= _BEFORE and self._is_last(vehicle) else left - _BEFORE
            else:
                at = path.starts[lane] + position
                if lane == path.to and position > t.length[slot] + _BEHIND:
                    self._current[vehicle] = (lane, self._path_from(vehicle, lane))
                elif at < path.junction_at - _BEFORE:
                    far = path.junction_at - _BEFORE - at
                elif not path.crossed:
                    far = path.starts[path.to] - at
                else:
                    slots.append(slot)
                    positions.append(at)
                    users.append(self._user(path, float(t.width[slot]) / 2))
            if far > 0:
                self._due[slot] = t.step + int(far / reach[slot])
        return Turns(np.array(slots, np.int64), np.array(positions), np.array(users, np.int64))

    def _stood(self) -> dict[int, tuple[float, int]]:
        """Who was near a junction and has not moved since: slot -> where on its path [m], and its user."""
        t, last = self._traffic, self.turns
        if not len(last.slot):
            return {}
        there = t.here[last.slot] & ~t.fresh[last.slot]
        slots = last.slot[there]
        t.follow(slots)
        still = (t.speed[slots] == 0) & (t.old_speed[slots] == 0)
        at, user = last.at[there][still].tolist(), last.user[there][still].tolist()
        return dict(zip(slots[still].tolist(), zip(at, user, strict=True), strict=True))

    def _follow(self, vehicle: str) -> tuple[str, Path | None, float]:
        """The lane that a vehicle is on now, its path, and how far it is along the lane [m]."""
        lane = libsumo.vehicle.getLaneID(vehicle)
        was, path = self._current.get(vehicle, ("", None))
        if lane != was:
            if path is None or lane not in path.starts:
                path = self._path_from(vehicle, lane)
            self._current[vehicle] = (lane, path)
        return lane, path, libsumo.vehicle.getLanePosition(vehicle)

    def _user(self, path: Path, half_width: float) -> int:
        key = path, half_width
        if key not in self._numbers:
            self._numbers[key] = len(self.users)
            self.users.append(key)
            self._junction_of.append(self._junctions.setdefault(path.junction, len(self._junctions)))
        return self._numbers[key]

    def _zones_of(self, own: Ints, other: Ints) -> Floats:
        """(k, 4) where the paths of two users cross: from and to along the own, from and to along the other [m]."""
        keys = own * 2**32 + other
        at = np.searchsorted(self._keys, keys)
        known = self._keys[at] == keys
        if not known.all():
            new = np.unique(keys[~known])
            behind = np.searchsorted(self._keys, new)
            self._keys = np.insert(self._keys, behind, new)
            zones = [self._zone(*divmod(key, 2**32)) for key in new.tolist()]
            self._zones = np.insert(self._zones, behind, zones, axis=0)
            at = np.searchsorted(self._keys, keys)
        result: Floats = self._zones[at]
        return result

    def _zone(self, own: int, other: int) -> tuple[float, float, float, float]:
        (path, half), (crossed, other_half) = self.users[own], self.users[other]
        zone = crossing_zone(
            *(path.points, path.heading, crossed.points, crossed.heading), width=half + other_half, spacing=_SPACING
        )
        if zone is None:
            return np.nan, np.nan, np.nan, np.nan
        return (
            path.origin + zone.own_from,
            path.origin + zone.own_to,
            crossed.origin + zone.other_from,
            crossed.origin + zone.other_to,
        )

    @staticmethod
    def _is_last(vehicle: str) -> bool:
        """Whether a vehicle's route ends on the edge where it is."""
        return bool(libsumo.vehicle.getRouteIndex(vehicle) + 1 >= len(libsumo.vehicle.getRoute(vehicle)))

    def _path_from(self, vehicle: str, lane: str) -> Path | None:
        """The path on from a lane: through the next junction, or the one that the lane is inside of; None if none."""
        edges, at = libsumo.vehicle.getRoute(vehicle), libsumo.vehicle.getRouteIndex(vehicle)
        if not lane or at < 0 or at + 1 >= len(edges):
            return None
        # While a vehicle is inside a junction, its current edge is still the one before it.
        inside = lane.startswith(":")
        for approach in self._network.lanes(edges[at]) if inside else (lane,):
            for link in self._network.links(approach):
                if lane in link.via if inside else self._network.edge(link.to) == edges[at + 1]:
                    if (approach, link) not in self._known:
                        self._known[approach, link] = self._build(approach, link)
                    return self._known[approach, link]
        return None

    def _build(self, lane: str, link: Link) -> Path:
        net = self._network
        lanes = [lane, *link.via, link.to]
        starts, shapes, length = {}, [], 0.0
        for each in lanes:
            starts[each] = length
            length += net.length(each)
            shapes.append(net.shape(each))
        line = np.vstack(shapes)
        line = line[np.concatenate([[True], np.hypot(*np.diff(line, axis=0).T) > 1e-6])]
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
        begin = starts[lanes[1]]
        origin = max(0.0, begin - 10.0)
        at = np.arange(origin, min(length, starts[link.to] + 10.0), _SPACING)
        # SUMO's lane lengths may differ a little from those of their shapes; positions are in the former.
        on_line = at * along[-1] / length
        points = np.column_stack([np.interp(on_line, along, line[:, k]) for k in (0, 1)])
        tangent = np.gradient(points, axis=0)
        return Path(
            points,
            np.arctan2(tangent[:, 1], tangent[:, 0]),
            origin,
            starts,
            link.to,
            begin,
            net.junction(lane),
            any(net.foes(each) for each in link.via),
            link.direction,
            net.edge(lane),
            link.direction in _TURNS or link.minor,
        )
