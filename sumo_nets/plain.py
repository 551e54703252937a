"""Writes an `Intersection` as plain XML for netconvert, with its signal and its buildings.

Edges are `{arm}i` to the centre `c` and `{arm}o` away from it: lane 0 is the bicycle lane, 1 to n are the car lanes
from the outermost. With riders against the lane there are `{arm}ci` and `{arm}co` too, beyond the bicycle lanes of
`{arm}o` and `{arm}i`. Where riders turn left in two stages, those who come from an arm wait on `{arm}lo`, `{arm}li`,
which begin and end in the centre; SUMO's own indirect left turns do not see the cars that turn left towards them.
"""

import math
from collections.abc import Iterable
from pathlib import Path

from sumo_nets.intersection import AGAINST, ARMS, LEFT, OPPOSITE, RIGHT, Intersection

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
        "con": ("connections", [_element("connection", row) for row in links] + _prohibitions(it, links)),
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
            elif it.waiting_area(arm):
                away, aside = it.waiting_area(arm)[0]
                way = ((it.stop, it.bike), (away + 1.3 * (aside - it.bike), it.bike), (away, aside))
                shape: Row = {"shape": _text(it.at(arm, *point) for point in way), "keepClear": "false"}
                rows.append({"from": f"{arm}i", "to": f"{arm}lo", "fromLane": 0, "toLane": 0} | shape)
                rows.append({"from": f"{arm}li", "to": f"{to}o", "fromLane": 0, "toLane": 0})
            elif it.bike_left != "none":
                rows.append(ends | {"fromLane": 0, "toLane": 0})
            for lane in it.car_lanes(arm, where):
                row = ends | {"fromLane": lane, "toLane": lane}
                if where == "left":
                    path = [it.at(arm, it.stop - forward, it.inner - left) for forward, left in points.tolist()]
                    row |= {"speed": f"{speed:.2f}", "contPos": it.waits_at(arm), "shape": _text(path)}
                elif where == "right":
                    path = [it.at(arm, *point) for point in it.right_turn(lane)]
                    row |= {"contPos": 0, "shape": _text(path)}  # they wait at the stop line for riders beside them
                rows.append(row)
            if where == "straight" and it.contraflow:
                rows.append({"from": f"{arm}ci", "to": f"{to}co", "fromLane": 0, "toLane": 0})
    return rows


def _prohibitions(it: Intersection, links: list[Row]) -> list[str]:
    """Whom to let pass, where netconvert, which goes by the order and the angles of the arms, does not see it.

    Cars that turn right cross the way of riders against the lane on both roads, and that of riders who come out of a
    waiting area, as do riders on their way there. Who goes straight on against the lane has the right of way of his
    road, as others there.
    """
    ways = {(str(row["from"]), str(row["to"])) for row in links}
    rows = []
    for prohibitor, beyond in sorted(ways):
        arm, kind = prohibitor[0], prohibitor[1:]
        for prohibited, to in sorted(ways):
            other, turn = prohibited[0], _turn(prohibited, to)
            if kind == "ci":
                crosses = turn == "right" and arm in (OPPOSITE[other], to[0])
                crosses |= turn == "left" and arm in (OPPOSITE[other], other)
                crosses |= to.endswith("lo") and arm == OPPOSITE[other]
                along = to[0] if prohibited.endswith("li") else other
                crosses |= not it.signal and turn == "straight" and arm in it.main and along not in it.main
            else:
                crosses = kind == "li" and turn == "right" and (other, to[0]) == (OPPOSITE[beyond[0]], OPPOSITE[arm])
            if crosses:
                rows.append(f'<prohibition prohibitor="{prohibitor}-&gt;{beyond}" prohibited="{prohibited}-&gt;{to}"/>')
    return rows


def _turn(begin: str, to: str) -> str:
    """`left`, `right` or `straight`, which is also who goes to a waiting area or on from there."""
    if begin[1:] != "i" or to[1:] != "o":
        return "straight"
    return {LEFT[begin[0]]: "left", RIGHT[begin[0]]: "right"}.get(to[0], "straight")


def _nodes(it: Intersection) -> list[str]:
    ring = []
    for arm in "senw":
        ring += [it.at(arm, it.stop if arm in it.arms else it.half_width, side * it.half_width) for side in (-1, 1)]
        if {arm, RIGHT[arm]} <= set(it.arms) and it.waiting_area(LEFT[arm]):
            begin, _, end = it.waiting_area(LEFT[arm])  # netconvert cuts edges off where they enter the junction
            ring += [it.at(LEFT[arm], *begin), it.at(LEFT[arm], *end)]
    kind = "traffic_light" if it.signal else "priority"
    rows = [f'<node id="c" x="0" y="0" type="{kind}" shape="{_text(ring)}"/>']
    for arm in (a for a in ARMS if a in it.arms):
        x, y = it.at(arm, it.arm_length, 0.0)
        rows.append(f'<node id="{arm}" x="{x:g}" y="{y:g}"/>')
        if _against(it, arm):
            for suffix, side in (("ci", -1), ("co", 1)):
                x, y = it.at(arm, it.arm_length, side * it.against)
                rows.append(f'<node id="{arm}{suffix}" x="{x:.3f}" y="{y:.3f}"/>')
        if it.waiting_area(arm):
            x, y = it.at(arm, *it.waiting_area(arm)[1])
            rows.append(f'<node id="{arm}l" x="{x:.3f}" y="{y:.3f}"/>')
    return rows


def _edges(it: Intersection) -> list[str]:
    rows = []
    far, near = it.arm_length, it.stop
    for arm in (a for a in ARMS if a in it.arms):
        major, crossing = (2 if it.signal or a in it.main else 1 for a in (arm, LEFT[arm]))
        for out in (False, True):
            side = -1 if out else 1
            along = (near, far) if out else (far, near)
            lanes = []
            for index in range(it.lanes + 1):
                line = _text(it.at(arm, away, side * it.lane(index)) for away in along)
                rule = 'disallow="bicycle pedestrian"' if index else 'allow="bicycle"'
                width = it.lane_width if index else it.bike_lane
                lanes.append(f'<lane index="{index}" {rule} width="{width:g}" shape="{line}"/>')
            middle = (it.median / 2 + it.half_width) / 2
            rows.append(
                _edge(it, arm, "o" if out else "i", it.lanes + 1, major)
                + f'shape="{_text(it.at(arm, away, side * middle) for away in along)}">{"".join(lanes)}</edge>'
            )
            if _against(it, arm):
                line = _text(it.at(arm, away, -side * it.against) for away in along)
                # netconvert tells by the edges' angles, 10 m from the junction, who lies beside whom: these lie outside
                # of all others, but not so much that it would take straight on for a turn.
                bulge = ((near, it.against), (near + 10.0, it.against + _BULGE), (far, it.against + _BULGE))
                fan = _text(it.at(arm, away, -side * aside) for away, aside in (bulge if out else bulge[::-1]))
                rows.append(
                    _edge(it, arm, "co" if out else "ci", 1, major)
                    + f'shape="{fan}"><lane index="0" allow="bicycle" width="{AGAINST:g}" shape="{line}"/></edge>'
                )
        if it.waiting_area(arm):
            begin, corner, end = (it.at(arm, *point) for point in it.waiting_area(arm))
            for suffix, ends in (("lo", (begin, corner)), ("li", (corner, end))):
                rows.append(
                    _edge(it, arm, suffix, 1, crossing)
                    + f'allow="bicycle" width="{min(it.bike_lane, 1.5):g}" shape="{_text(ends)}"/>'
                )
    return rows


def _against(it: Intersection, arm: str) -> bool:
    """Whether riders come along an arm against the lane: only to go straight on."""
    return it.contraflow and OPPOSITE[arm] in it.arms


def _edge(it: Intersection, arm: str, suffix: str, lanes: int, priority: int) -> str:
    outer = {"i": arm, "o": arm, "li": f"{arm}l", "lo": f"{arm}l"}.get(suffix, arm + suffix)
    ends = ("c", outer) if suffix.endswith("o") else (outer, "c")
    return (
        f'<edge id="{arm}{suffix}" from="{ends[0]}" to="{ends[1]}" numLanes="{lanes}" speed="{it.speed_limit:g}" '
        f'priority="{priority}" spreadType="center" '
    )


def _signal(it: Intersection, links: list[Row]) -> list[str]:
    """Two phases, one per axis; who turns may go when there is nobody to yield to."""
    states = {}
    for axis in ("ns", "ew"):
        letters = []
        for row in links:
            begin, to = str(row["from"]), str(row["to"])
            if begin.endswith("li"):  # with the crossing road
                letters.append("g" if to[0] in axis else "r")
            else:
                straight = to[0] == OPPOSITE[begin[0]] or (to.endswith("lo") and not it.contraflow)
                letters.append("r" if begin[0] not in axis else "G" if straight else "g")
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
        rows.append(_element("connection", ends | {"tl": "c", "linkIndex": index}))
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
