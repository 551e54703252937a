"""Writes the plain-XML sources of `w0`, the two-way intersection without median of Yan et al. 2025 (type W0).

Every arm has one car lane and one e-bike lane each way. Widths are chosen so that the lateral offset between the path
of the car that turns left and that of the oncoming e-bike is a = 4.8 m (Table 1, W0): half the own car lane, the
oncoming car lane, half the e-bike lane = 1.4 + 2.8 + 0.6. The left turn is the path of Table 3 for 20 km/h, the mean
speed of the source's accidents; the stop lines lie where that path begins. A signal with two phases lets left turns go
on permissive green, so they yield to oncoming traffic; right turns wait at the stop line for e-bikes beside them.

    python -m sumo_nets.build w0
"""

from pathlib import Path

from sumo_nets.turning_path import YAN_TABLE_3

CAR_LANE = 2.8  # m, our assumption (see above)
BIKE_LANE = 1.2  # m, our assumption (see above)
ARM = 250.0  # m from the centre to the end of an arm, our assumption
WAIT_AFTER = 6.0  # m into the turn, our assumption: where a car waits for a gap, still clear of the oncoming car lane
TURN_SPEED = 20 / 3.6  # m/s, printed

_INBOUND = {"s": (0, 1), "w": (1, 0), "n": (0, -1), "e": (-1, 0)}  # heading of who comes from that arm
_LEFT = {"s": "w", "e": "s", "n": "e", "w": "n"}  # where a left turn leads
_OPPOSITE = {"s": "n", "n": "s", "e": "w", "w": "e"}


def write(target: Path) -> None:
    """Write `w0.nod.xml`, `w0.edg.xml` and `w0.con.xml` into `target`."""
    turn = YAN_TABLE_3[20].points(2.0)
    centre = CAR_LANE / 2
    stop = round(float(turn[-1, 0]) - centre, 2)
    half = CAR_LANE + BIKE_LANE

    corners = [(-half, -stop), (half, -stop), (stop, -half), (stop, half), (half, stop), (-half, stop)]
    shape = " ".join(f"{x},{y}" for x, y in [*corners, (-stop, half), (-stop, -half)])
    nodes = [f'<node id="c" x="0" y="0" type="traffic_light" shape="{shape}"/>']
    edges, connections = [], []
    for arm, (hx, hy) in _INBOUND.items():
        nodes.append(f'<node id="{arm}" x="{-hx * ARM}" y="{-hy * ARM}"/>')
        lanes = f'<lane index="0" allow="bicycle" width="{BIKE_LANE}"/><lane index="1" disallow="bicycle pedestrian" '
        for suffix, ends in (("i", (arm, "c")), ("o", ("c", arm))):
            edges.append(
                f'<edge id="{arm}{suffix}" from="{ends[0]}" to="{ends[1]}" numLanes="2" speed="13.89" '
                f'priority="2">{lanes}width="{CAR_LANE}"/></edge>'
            )
        left_x, left_y = -hy, hx
        x0, y0 = -hx * stop - left_x * centre, -hy * stop - left_y * centre
        path = " ".join(f"{x0 + hx * f + left_x * lft:.2f},{y0 + hy * f + left_y * lft:.2f}" for f, lft in turn)
        right = next(a for a in _INBOUND if a not in (arm, _LEFT[arm], _OPPOSITE[arm]))
        for to, lane, extra in (
            (_OPPOSITE[arm], 0, ""),
            (_OPPOSITE[arm], 1, ""),
            (right, 1, ' contPos="0"'),
            (_LEFT[arm], 1, f' speed="{TURN_SPEED:.2f}" contPos="{WAIT_AFTER}" shape="{path}"'),
        ):
            connections.append(f'<connection from="{arm}i" to="{to}o" fromLane="{lane}" toLane="{lane}"{extra}/>')
    for kind, tag, rows in (("nod", "nodes", nodes), ("edg", "edges", edges), ("con", "connections", connections)):
        text = "\n".join([f"<{tag}>", *("    " + row for row in rows), f"</{tag}>", ""])
        (target / f"w0.{kind}.xml").write_text(text, encoding="utf-8")
