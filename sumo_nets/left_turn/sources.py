"""Writes the plain-XML sources of `left_turn`: a car turns left across the path of an oncoming e-bike.

The test of Yan et al. 2025 for intersections of type W0, once for each of its speeds (10, 20, 30 km/h), 1 km apart.
Every name ends with the speed: the car drives `car_20`, `exit_20` (route `turn_20`), the e-bike `ebike_20`, `beyond_20`
(route `straight_20`). The car comes from the south and leaves to the west; its turn, one lane inside the junction, is
the path of Table 3. The exit goes exactly to the west, which evens out the 0.08 or 0.12 deg by which the printed angles
miss 90 deg (shared/seeds.md 4.2). The e-bike goes from north to south and has the right of way.

    python -m sumo_nets.build left_turn
"""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from sumo_nets.turning_path import YAN_TABLE_3

__all__ = ["APPROACH", "BEHIND", "CAR_LANE", "OFFSET", "SPACING", "crossing", "start_of_turn", "write"]

OFFSET = 4.8  # m, printed (Table 1, W0, "average width"; read as this offset, seeds.md 4.1): car to e-bike path
APPROACH = 150.0  # m, our assumption: of the car before its turn, of the e-bike before it crosses the car's path
BEHIND = 60.0  # m, our assumption: of the e-bike behind the crossing, and of the car behind its turn
CAR_LANE = 3.2  # m, our assumption
BIKE_LANE = 1.2  # m, our assumption
SPACING = 0.25  # m between the points of a turn, our assumption
_APART = 1000.0  # m between junctions, our assumption
_LIMIT = 20.0  # m/s, our assumption: above every speed of the test


def start_of_turn(speed_kmh: int) -> tuple[float, float]:
    """Where the turn for this speed [km/h] begins, heading to the north (+y) [m]."""
    return sorted(YAN_TABLE_3).index(speed_kmh) * _APART, 0.0


def crossing(speed_kmh: int) -> tuple[float, float]:
    """Where the turn for this speed [km/h] crosses the e-bike's path.

    Returns:
        Distance along the turn, that is along the lane inside the junction, and distance to the north of where the turn
        begins [m]. The e-bike is `APPROACH` from there when its lane begins.
    """
    forward, left = YAN_TABLE_3[speed_kmh].points(SPACING).T
    along = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(forward), np.diff(left)))])
    return float(np.interp(OFFSET, left, along)), float(np.interp(OFFSET, left, forward))


def write(target: Path) -> None:
    """Write `left_turn.nod.xml`, `left_turn.edg.xml` and `left_turn.con.xml` into `target`."""
    nodes, edges, connections = [], [], []
    for v, path in YAN_TABLE_3.items():
        x0, y0 = start_of_turn(v)
        forward, left = path.points(SPACING).T
        xb, meet = x0 - OFFSET, y0 + crossing(v)[1]
        xe, ye = x0 - float(left[-1]), y0 + float(forward[-1])
        top = ye + CAR_LANE
        east, west = x0 + CAR_LANE / 2, xb - BIKE_LANE / 2
        ring = [(west, y0), (east, y0), (east, top), (west, top), (xe, top), (xe, ye - CAR_LANE / 2)]
        lines = {
            "car": ((x0, y0 - APPROACH), (x0, y0), "start", 1, "disallow", CAR_LANE),
            "exit": ((xe, ye), (xe - BEHIND, ye), "end", 1, "disallow", CAR_LANE),
            "ebike": ((xb, meet + APPROACH), (xb, top), "north", 2, "allow", BIKE_LANE),
            "beyond": ((xb, y0), (xb, meet - BEHIND), "south", 2, "allow", BIKE_LANE),
        }
        nodes.append(f'<node id="c_{v}" x="{x0}" y="{y0}" type="priority" shape="{_text(ring)}"/>')
        for name, (begin, end, outer, priority, rule, width) in lines.items():
            inbound = name in ("car", "ebike")
            x, y = begin if inbound else end
            nodes.append(f'<node id="{outer}_{v}" x="{x:.3f}" y="{y:.3f}"/>')
            ends = (f"{outer}_{v}", f"c_{v}") if inbound else (f"c_{v}", f"{outer}_{v}")
            classes = "bicycle" if rule == "allow" else "bicycle pedestrian"
            edges.append(
                f'<edge id="{name}_{v}" from="{ends[0]}" to="{ends[1]}" numLanes="1" speed="{_LIMIT}" '
                f'priority="{priority}" spreadType="center" {rule}="{classes}" width="{width}" '
                f'shape="{_text([begin, end])}"/>'
            )
        turn = _text(zip((x0 - left).tolist(), (y0 + forward).tolist(), strict=True))
        connections += [
            f'<connection from="car_{v}" to="exit_{v}" fromLane="0" toLane="0" contPos="0" speed="{_LIMIT}" '
            f'shape="{turn}"/>',
            f'<connection from="ebike_{v}" to="beyond_{v}" fromLane="0" toLane="0" speed="{_LIMIT}"/>',
        ]
    for kind, tag, rows in (("nod", "nodes", nodes), ("edg", "edges", edges), ("con", "connections", connections)):
        text = "\n".join([f"<{tag}>", *("    " + row for row in rows), f"</{tag}>", ""])
        (target / f"left_turn.{kind}.xml").write_text(text, encoding="utf-8")


def _text(points: Iterable[tuple[float, float]]) -> str:
    return " ".join(f"{x:.3f},{y:.3f}" for x, y in points)
