"""Where vehicles mean to go: their planned paths through the next junction, and where these cross."""

from dataclasses import dataclass

import libsumo
import numpy as np

from aeb_sumo.perception.crossing import Zone, crossing_zone
from aeb_sumo.soa import Floats, Ints
from aeb_sumo.world.network import Link, Network
from aeb_sumo.world.observe import Traffic

__all__ = ["Path", "Paths", "Turn"]

_SPACING = 0.5  # m between the points of a path
_BEFORE = 60.0  # m before a junction at which a vehicle's path through it begins to matter, our assumption
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


@dataclass(frozen=True)
class Turn:
    """A vehicle on its path: slot, path, distance of the front bumper along it [m], half its width [m]."""

    slot: int
    path: Path
    at: float
    half_width: float


class Paths:
    """Planned paths of vehicles, followed lane by lane."""

    def __init__(self, traffic: Traffic, network: Network) -> None:
        self._traffic = traffic
        self._network = network
        self._known: dict[tuple[str, Link], Path] = {}
        self._current: dict[str, tuple[str, Path | None]] = {}  # vehicle -> (lane, path)
        self._zones: dict[tuple[Path, Path, float], Zone | None] = {}

    def near_junctions(self, slots: Ints) -> list[Turn]:
        """Of these vehicles, those from 60 m before a junction until their tail is out of it, if others cross there."""
        t, turns = self._traffic, []
        for _, vehicle in t.left:
            self._current.pop(vehicle, None)
        lane_id, lane_position = libsumo.vehicle.getLaneID, libsumo.vehicle.getLanePosition
        for slot in slots.tolist():
            vehicle = t.ids[slot]
            lane = lane_id(vehicle)
            was, path = self._current.get(vehicle, ("", None))
            if lane != was:
                if path is None or lane not in path.starts:
                    path = self._path_from(vehicle, lane)
                self._current[vehicle] = (lane, path)
            if path is None:
                continue
            at = path.starts[lane] + lane_position(vehicle)
            if lane == path.to and at - path.starts[lane] > t.length[slot] + _BEHIND:
                path = self._path_from(vehicle, lane)
                self._current[vehicle] = (lane, path)
            elif path.crossed and at >= path.junction_at - _BEFORE:
                turns.append(Turn(slot, path, at, float(t.width[slot]) / 2))
        return turns

    def zone(self, own: Turn, other: Turn) -> Zone | None:
        """Where the paths of two vehicles through the same junction cross; distances are along the paths."""
        key = own.path, other.path, own.half_width + other.half_width
        if key not in self._zones:
            zone = crossing_zone(
                *(own.path.points, own.path.heading, other.path.points, other.path.heading),
                width=key[2],
                spacing=_SPACING,
            )
            self._zones[key] = zone and Zone(
                own.path.origin + zone.own_from,
                own.path.origin + zone.own_to,
                other.path.origin + zone.other_from,
                other.path.origin + zone.other_to,
            )
        return self._zones[key]

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
        )
