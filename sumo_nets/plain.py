"""Writes an `Intersection` as plain XML for netconvert, with its signal and its buildings.

Edges are `{arm}i` to the centre `c` and `{arm}o` away from it: lane 0 is the bicycle lane, 1 to n are the car lanes
from the outermost. With riders against the lane there are `{arm}ci` and `{arm}co` too, on the bicycle lanes of `{arm}o`
and `{arm}i`.
"""

import math
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

from sumo_nets.intersection import ARMS, LEFT, OPPOSITE, RIGHT, Intersection

__all__ = ["connections", "write"]

_SPACING = 2.0  # m between the points of a turn
_RIDER = 17.0 / 3.6  # m/s, that of a rider who has to be out of the junction before the others get green
_YELLOW = 3.0  # s, our assumption
_BULGE = 0.2  # m

Row = dict[str, object]


def write(intersection: Intersection, target: Path, name: str) -> None:
    """Write the sources `{name}.*.xml`, the configuration `{name}.netccfg` and the buildings `{name}.add.xml`."""
    it = intersection
    links = connections(it)
    files = {
        "nod": ("nodes", _nodes(it)),
        "edg": ("edges", _edges(it)),
        "con": ("connections", [_element("connection", row) for row in links] + _prohibitions(it)),
        "add": ("additional", _buildings(it)),
    }
    if it.signal:
        files["tll"] = ("tlLogics", _signal(it, links))
    for kind, (tag, rows) in files.items():
        text = "\n".join([f"<{tag}>", *("    " + row for row in rows), f"</{tag}>", ""])
        (target / f"{name}.{kind}.xml").write_text(text, encoding="utf-8")
    signal = f'\n        <tllogic-files value="{name}.tll.xml"/>' if it.signal else ""
    (target / f"{name}.netccfg").write_text(_CONFIGURATION.format(name=name, signal=signal), encoding="utf-8")


def connections(it: Intersection) -> list[Row]:
    """The connections, in the order of the signal's links, as attributes of plain XML."""
    rows = []
    turn, speed = it.turn
    points = turn.points(_SPACING)
    for arm in (a for a in ARMS if a in it.arms):
        for where, to in it.movements(arm).items():
            ends: Row = {"from": f"{arm}i", "to": f"{to}o"}
            if where != "left":
                rows.append(ends | {"fromLane": 0, "toLane": 0})
            elif it.bike_left == "two_stage":
                path, waits = _two_stages(it)
                shape = _text(it.at(arm, away, aside) for away, aside in path)
                rows.append(ends | {"fromLane": 0, "toLane": 0, "indirect": "true", "contPos": waits, "shape": shape})
            elif it.bike_left == "one_stage":
                rows.append(ends | {"fromLane": 0, "toLane": 0})
            for lane in it.car_lanes(arm, where):
                row = ends | {"fromLane": lane, "toLane": lane}
                if where == "left":
                    path = [it.at(arm, it.stop - forward, it.inner - left) for forward, left in points.tolist()]
                    row |= {"speed": f"{speed:.2f}", "contPos": it.waits_at, "shape": _text(path)}
                elif where == "right":
                    row |= {"contPos": 0}  # at the stop line, for riders beside
                rows.append(row)
            if where == "straight" and it.contraflow:
                rows.append({"from": f"{arm}ci", "to": f"{to}co", "fromLane": 0, "toLane": 0})
    return rows


def _prohibitions(it: Intersection) -> list[str]:
    """Who has to yield where netconvert, which goes by the order of the arms, sees no conflict.

    Cars that turn right cross the way of riders against the lane on both roads, and in a narrow corner that of riders
    who turn left in two stages, who in turn cross that of the former.
    """
    rows = []
    for arm in (a for a in ARMS if a in it.arms):
        right, left = RIGHT[arm], LEFT[arm]
        if _against(it, arm) and left in it.arms:
            rows.append((f"{OPPOSITE[arm]}ci", f"{arm}co", arm, left))
        if right not in it.arms:
            continue
        if _against(it, right):
            rows.append((f"{right}ci", f"{OPPOSITE[right]}co", arm, right))
        if _against(it, arm):
            rows.append((f"{OPPOSITE[arm]}ci", f"{arm}co", arm, right))
        if it.bike_left == "two_stage" and {OPPOSITE[right], OPPOSITE[arm]} <= set(it.arms):
            rows.append((f"{OPPOSITE[right]}i", f"{OPPOSITE[arm]}o", arm, right))
    return [f'<prohibition prohibitor="{a}-&gt;{b}" prohibited="{c}i-&gt;{d}o"/>' for a, b, c, d in rows]


def _two_stages(it: Intersection) -> tuple[list[tuple[float, float]], float]:
    """Path of a rider who turns left with the crossing road, `away` and `aside` as in `Intersection.at`.

    Straight on, then aside to where those who go straight on pass, and round into the crossing road's bicycle lane.

    Returns:
        The path, and how far into it he waits [m].
    """
    a, box, radius = it.bike, 2.5, 1.5
    first = [(it.stop, a), (6.0 - a, a), (4.5 - a, a + 0.4), (2.5 - a, a + box - 0.4), (radius - a, a + box)]
    bend = [math.radians(d) for d in (30, 60, 90)]
    second = [(radius - a - radius * math.sin(b), a + box - radius * (1 - math.cos(b))) for b in bend]
    waits = sum(math.dist(p, q) for p, q in pairwise(first))
    return [*first, *second, (-a, -it.stop)], round(waits, 2)


def _nodes(it: Intersection) -> list[str]:
    ring = []
    for arm in "senw":
        ring += [it.at(arm, it.stop if arm in it.arms else it.half_width, side * it.half_width) for side in (-1, 1)]
    kind = "traffic_light" if it.signal else "priority"
    rows = [f'<node id="c" x="0" y="0" type="{kind}" shape="{_text(ring)}"/>']
    for arm in (a for a in ARMS if a in it.arms):
        x, y = it.at(arm, it.arm_length, 0.0)
        rows.append(f'<node id="{arm}" x="{x:g}" y="{y:g}"/>')
        if _against(it, arm):
            for suffix, side in (("ci", -1), ("co", 1)):
                x, y = it.at(arm, it.arm_length, side * it.bike)
                rows.append(f'<node id="{arm}{suffix}" x="{x:.3f}" y="{y:.3f}"/>')
    return rows


def _edges(it: Intersection) -> list[str]:
    rows = []
    far, near = it.arm_length, it.stop
    for arm in (a for a in ARMS if a in it.arms):
        major = 2 if it.signal or arm in it.main else 1
        for out in (False, True):
            side = -1 if out else 1
            ends = (near, far) if out else (far, near)
            lanes = []
            for index in range(it.lanes + 1):
                line = _text(it.at(arm, away, side * it.lane(index)) for away in ends)
                rule, width = (
                    ('allow="bicycle"', it.bike_lane) if index == 0 else ('disallow="bicycle pedestrian"', it.lane_width)
                )
                lanes.append(f'<lane index="{index}" {rule} width="{width:g}" shape="{line}"/>')
            middle = (it.median / 2 + it.half_width) / 2
            rows.append(
                _edge(it, arm, "o" if out else "i", it.lanes + 1, major)
                + f'shape="{_text(it.at(arm, away, side * middle) for away in ends)}">{"".join(lanes)}</edge>'
            )
            if _against(it, arm):
                line = _text(it.at(arm, away, -side * it.bike) for away in ends)
                # netconvert tells by the edges' angles, 10 m from the junction, who lies beside whom: these lie outside of
                # all others, but not so much that it would take straight on for a turn.
                bulge = ((near, it.bike), (near + 10.0, it.bike + _BULGE), (far, it.bike + _BULGE))
                fan = _text(it.at(arm, away, -side * aside) for away, aside in (bulge if out else bulge[::-1]))
                rows.append(
                    _edge(it, arm, "co" if out else "ci", 1, major)
                    + f'shape="{fan}"><lane index="0" allow="bicycle" width="{it.bike_lane:g}" shape="{line}"/></edge>'
                )
    return rows


def _against(it: Intersection, arm: str) -> bool:
    """Whether riders come along an arm against the lane: only to go straight on."""
    return it.contraflow and OPPOSITE[arm] in it.arms


def _edge(it: Intersection, arm: str, suffix: str, lanes: int, priority: int) -> str:
    outer = arm if len(suffix) == 1 else arm + suffix
    ends = ("c", outer) if suffix.endswith("o") else (outer, "c")
    return (
        f'<edge id="{arm}{suffix}" from="{ends[0]}" to="{ends[1]}" numLanes="{lanes}" speed="{it.speed_limit:g}" '
        f'priority="{priority}" spreadType="center" '
    )


def _signal(it: Intersection, links: list[Row]) -> list[str]:
    """Two phases, one per axis; who turns may go when there is nobody to yield to."""
    second = {index: len(links) + k for k, index in enumerate(i for i, row in enumerate(links) if "indirect" in row)}
    states = {}
    for axis in ("ns", "ew"):
        letters = []
        for row in links:
            arm, to = str(row["from"])[0], str(row["to"])[0]
            letters.append("r" if arm not in axis else "G" if to == OPPOSITE[arm] else "g")
        letters += ["G" if str(links[index]["to"])[0] in axis else "r" for index in second]
        states[axis] = "".join(letters)
    clear = max(1.0, math.ceil(2 * it.stop / _RIDER) - _YELLOW)
    rows = ['<tlLogic id="c" type="static" programID="0" offset="0">']
    for state in states.values():
        yellow = state.replace("G", "y").replace("g", "y")
        for duration, each in ((it.green, state), (_YELLOW, yellow), (clear, "r" * len(state))):
            rows.append(f'    <phase duration="{duration:g}" state="{each}"/>')
    rows.append("</tlLogic>")
    for index, row in enumerate(links):
        ends = {k: row[k] for k in ("from", "to", "fromLane", "toLane")}
        more = {"linkIndex2": second[index]} if index in second else {}
        rows.append(_element("connection", ends | {"tl": "c", "linkIndex": index} | more))
    return rows


def _buildings(it: Intersection) -> list[str]:
    return [
        f'<poly id="{name}" type="building" color="180,180,180" fill="1" layer="0" shape="{_text([*ring, ring[0]])}"/>'
        for name, ring in it.buildings().items()
    ]


def _element(tag: str, attributes: Row) -> str:
    return f"<{tag} " + " ".join(f'{key}="{value}"' for key, value in attributes.items()) + "/>"


def _text(points: Iterable[tuple[float, float]]) -> str:
    return " ".join(f"{x:.3f},{y:.3f}" for x, y in points)


_CONFIGURATION = """<configuration>
    <input>
        <node-files value="{name}.nod.xml"/>
        <edge-files value="{name}.edg.xml"/>
        <connection-files value="{name}.con.xml"/>{signal}
    </input>
    <output>
        <output-file value="{name}.net.xml"/>
        <precision value="3"/>
    </output>
    <processing>
        <offset.disable-normalization value="true"/>
        <no-turnarounds value="true"/>
    </processing>
</configuration>
"""
