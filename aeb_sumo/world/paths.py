"""Where vehicles mean to go: their planned paths through the next junction."""

from dataclasses import dataclass

import libsumo
import numpy as np

from aeb_sumo.soa import Floats, Ints
from aeb_sumo.world.network import Link, Network
from aeb_sumo.world.observe import Traffic

__all__ = ["Path", "Paths", "Turn"]

_SPACING = 0.5  # m between the points of a path
_BEFORE = 60.0  # m before a junction at which a vehicle's path through it begins to matter, our assumption
_BEYOND = 60.0  # m of a path behind the junction


@dataclass(frozen=True, eq=False)
class Path:
    """A path through a junction.

    Attributes:
        points: (n, 2) along the lanes' centres, `_SPACING` apart [m].
        heading: (n,) direction there [rad].
        starts: lane -> distance along the path at which it starts [m].
        junction_at: distance at which the junction begins [m].
        crosses: other lanes cross it inside the junction.
        direction: SUMO's letter of the turn.
    """

    points: Floats
    heading: Floats
    starts: dict[str, float]
    junction_at: float
    crosses: bool
    direction: str


@dataclass(frozen=True)
class Turn:
    """A vehicle on its path: slot, path, and distance of the front bumper along it [m]."""

    slot: int
    path: Path
    at: float


class Paths:
    """Planned paths of chosen vehicles, followed lane by lane."""

    def __init__(self, traffic: Traffic, network: Network) -> None:
        self._traffic = traffic
        self._network = network
        self._known: dict[tuple[str, Link], Path] = {}
        self._current: dict[str, tuple[str, Path | None]] = {}  # vehicle -> (lane, path)

    def near_junctions(self, slots: Ints) -> list[Turn]:
        """Of these vehicles, those within 60 m before or inside a junction in which others cross their path."""
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
            if path is not None and path.crosses:
                at = path.starts[lane] + lane_position(vehicle)
                if at >= path.junction_at - _BEFORE:
                    turns.append(Turn(slot, path, at))
        return turns

    def _path_from(self, vehicle: str, lane: str) -> Path | None:
        """The path on from a lane before a junction; None behind the last one, and when met in the middle of one."""
        if not lane or lane.startswith(":"):
            return None
        edges, at = libsumo.vehicle.getRoute(vehicle), libsumo.vehicle.getRouteIndex(vehicle)
        if at + 1 >= len(edges):
            return None
        for link in self._network.links(lane):
            if self._network.edge(link.to) == edges[at + 1]:
                if (lane, link) not in self._known:
                    self._known[lane, link] = self._build(lane, link)
                return self._known[lane, link]
        return None

    def _build(self, lane: str, link: Link) -> Path:
        net = self._network
        lanes = [lane, *link.via, link.to]
        starts, points, length = {}, [], 0.0
        for each in lanes:
            starts[each] = length
            length += net.length(each)
            points.append(net.shape(each))
        line = np.vstack(points)
        step = np.hypot(*np.diff(line, axis=0).T)
        keep = np.concatenate([[True], step > 1e-6])
        line = line[keep]
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
        # SUMO's lane lengths may differ a little from those of their shapes; positions are in the former.
        end = min(length, starts[link.to] + _BEYOND)
        at = np.arange(0.0, end, _SPACING)
        on_line = at * along[-1] / length
        xy = np.column_stack([np.interp(on_line, along, line[:, k]) for k in (0, 1)])
        tangent = np.gradient(xy, axis=0)
        crossed = any(self._crosses(mine, foe) for mine in link.via for foe in net.foes(mine))
        return Path(
            xy, np.arctan2(tangent[:, 1], tangent[:, 0]), starts, starts[lanes[1]], crossed, link.direction
        )

    def _crosses(self, mine: str, foe: str) -> bool:
        """Whether a conflicting lane crosses at an angle; one that merges or runs beside is a matter for followers."""
        mine_starts, foe_starts = (self._network.shape(x)[:2] for x in (mine, foe))
        turn = np.subtract(*(np.arctan2(*(s[1] - s[0])[::-1]) for s in (mine_starts, foe_starts)))
        return bool(np.cos(turn) < np.cos(np.pi / 6))
