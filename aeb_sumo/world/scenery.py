"""The stage: roads, buildings and signals around a place, for drawings."""

from dataclasses import dataclass

import libsumo

from aeb_sumo.soa import Floats
from aeb_sumo.world.buildings import walls

__all__ = ["Lane", "Scenery", "lights", "scenery"]

Points = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Lane:
    """A lane.

    Attributes:
        shape: points of its centre line [m].
        width: [m].
        kind: `road`, `bicycle` or `foot`, by who may use it.
        inside: it is in a junction.
    """

    shape: Points
    width: float
    kind: str
    inside: bool


@dataclass(frozen=True)
class Scenery:
    """What stands still.

    Attributes:
        lanes: by id.
        junctions: their outlines, by id [m].
        walls: x and y of either end [m].
        heads: lane -> the signals at its end, from the right: traffic light, and place in what `lights` says of it.
    """

    lanes: dict[str, Lane]
    junctions: dict[str, Points]
    walls: tuple[tuple[float, ...], ...]
    heads: dict[str, tuple[tuple[str, int], ...]]

    def __or__(self, other: "Scenery") -> "Scenery":
        """What is in either."""
        return Scenery(
            lanes=self.lanes | other.lanes,
            junctions=self.junctions | other.junctions,
            walls=tuple(dict.fromkeys(self.walls + other.walls)),
            heads=self.heads | other.heads,
        )


def scenery(low: Floats, high: Floats) -> Scenery:
    """What reaches into the rectangle between two corners (2,) [m]."""

    def near(points: Points) -> bool:
        return all(
            min(p[k] for p in points) <= high[k] and max(p[k] for p in points) >= low[k] for k in (0, 1)
        )  # of the box around it, which is enough for a drawing

    get = libsumo.lane
    lanes = {
        lane: Lane(shape, float(get.getWidth(lane)), _kind(lane), lane.startswith(":"))
        for lane in get.getIDList()
        if near(shape := _points(get.getShape(lane)))
    }
    outlines = {j: _points(libsumo.junction.getShape(j)) for j in libsumo.junction.getIDList()}
    return Scenery(
        lanes=lanes,
        junctions={j: shape for j, shape in outlines.items() if len(shape) > 2 and near(shape)},
        walls=tuple(wall for wall in map(tuple, walls().tolist()) if near((wall[:2], wall[2:]))),
        heads={lane: tuple(heads) for lane, heads in _heads().items() if lane in lanes and not lanes[lane].inside},
    )


def lights() -> dict[str, str]:
    """Traffic light -> its state now, in SUMO's letters."""
    get = libsumo.trafficlight
    return {light: str(get.getRedYellowGreenState(light)) for light in get.getIDList()}


def _heads() -> dict[str, list[tuple[str, int]]]:
    found: dict[str, list[tuple[str, int]]] = {}
    for light in libsumo.trafficlight.getIDList():
        for place, links in enumerate(libsumo.trafficlight.getControlledLinks(light)):
            for lane in dict.fromkeys(link[0] for link in links):
                found.setdefault(lane, []).append((light, place))
    return found


def _points(shape: tuple[tuple[float, ...], ...]) -> Points:
    return tuple((float(p[0]), float(p[1])) for p in shape)


def _kind(lane: str) -> str:
    allowed = set(libsumo.lane.getAllowed(lane))
    if not allowed or allowed - {"pedestrian", "wheelchair", "bicycle", "scooter"}:
        return "road"
    return "bicycle" if "bicycle" in allowed else "foot"
