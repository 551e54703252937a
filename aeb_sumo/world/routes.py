"""Ways through the network: the path of a vehicle's route through the next junction, and its line on the ground."""

from dataclasses import dataclass
from functools import cache

import libsumo
import numpy as np

from aeb_sumo.soa import Floats
from aeb_sumo.world.network import Link, Network

__all__ = ["SPACING", "Path", "Routes"]

SPACING = 0.5
"""Between the points of a path [m]."""

_TURNS = frozenset("lLrRt")


@dataclass(frozen=True, eq=False)
class Path:
    """A path from a lane through a junction.

    Attributes:
        points: (n, 2) along the lanes' centres from `origin` on, `SPACING` apart [m].
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


class Routes:
    """The paths of a network, each built when a vehicle first means to take it."""

    def __init__(self, network: Network) -> None:
        self.line = cache(self._line)
        self._network = network
        self._known: dict[tuple[str, Link], Path] = {}

    def onward(self, vehicle: str, lane: str) -> Path | None:
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

    @staticmethod
    def ends_here(vehicle: str) -> bool:
        """Whether a vehicle's route ends on the edge where it is."""
        return bool(libsumo.vehicle.getRouteIndex(vehicle) + 1 >= len(libsumo.vehicle.getRoute(vehicle)))

    def _line(self, lane: str, path: Path | None) -> tuple[Floats, Floats]:
        """Centre line of a lane and those behind it on a path: (n, 2) points and (n,) distances along it [m]."""
        lanes = [lane] if path is None or lane not in path.starts else list(path.starts)
        return _joined([self._network.shape(each) for each in lanes[lanes.index(lane) :]])

    def _build(self, lane: str, link: Link) -> Path:
        net = self._network
        lanes = [lane, *link.via, link.to]
        starts, shapes, length = {}, [], 0.0
        for each in lanes:
            starts[each] = length
            length += net.length(each)
            shapes.append(net.shape(each))
        line, along = _joined(shapes)
        begin = starts[lanes[1]]
        origin = max(0.0, begin - 10.0)
        at = np.arange(origin, min(length, starts[link.to] + 10.0), SPACING)
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


def _joined(shapes: list[Floats]) -> tuple[Floats, Floats]:
    """Lines, each beginning where the last one ends, as one: (n, 2) points and (n,) distances along it [m]."""
    line = np.vstack(shapes)
    line = line[np.concatenate([[True], np.hypot(*np.diff(line, axis=0).T) > 1e-6])]
    return line, np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
