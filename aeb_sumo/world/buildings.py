"""Buildings of the scenario: what stands beside the road and hides what is behind it."""

import libsumo
import numpy as np

from aeb_sumo.soa import Floats

__all__ = ["walls"]

_BUILDING = "building"  # what the types of building polygons start with, as polyconvert names them: "building.house"


def walls() -> Floats:
    """(m, 4) walls of all buildings, x and y of either end [m].

    Buildings are SUMO's polygons whose type starts with "building" (from additional files; polyconvert imports them so
    from OpenStreetMap). A polygon whose last point is not its first is closed here.
    """
    found = [np.zeros((0, 4))]
    for polygon in libsumo.polygon.getIDList():
        if libsumo.polygon.getType(polygon).startswith(_BUILDING):
            corners = np.array(libsumo.polygon.getShape(polygon), float)
            found.append(np.column_stack([corners, np.roll(corners, -1, axis=0)]))
    pieces = np.vstack(found)
    result: Floats = pieces[(pieces[:, :2] != pieces[:, 2:]).any(axis=1)]
    return result
