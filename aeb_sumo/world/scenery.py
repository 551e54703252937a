"""What stands still: the road and the buildings around a place, for drawings."""

from dataclasses import dataclass

import libsumo

from aeb_sumo.soa import Floats
from aeb_sumo.world.buildings import walls

__all__ = ["Lane", "Scenery", "scenery"]

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
    """Lanes by id, outlines of junctions by id [m], and walls, x and y of either end [m]."""

    lanes: dict[str, Lane]
    junctions: dict[str, Points]
    walls: tuple[tuple[float, ...], ...]

    def __or__(self, other: "Scenery") -> "Scenery":
        """What is in either."""
        return Scenery(
            self.lanes | other.lanes, self.junctions | other.junctions, tuple(dict.fromkeys(self.walls + other.walls))
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
    )


def _points(shape: tuple[tuple[float, ...], ...]) -> Points:
    return tuple((float(p[0]), float(p[1])) for p in shape)


def _kind(lane: str) -> str:
    allowed = set(libsumo.lane.getAllowed(lane))
    if not allowed or allowed - {"pedestrian", "wheelchair", "bicycle", "scooter"}:
        return "road"
    return "bicycle" if "bicycle" in allowed else "foot"
