"""A network and its traffic several times side by side: the same traffic per vehicle, for larger fleets."""

from collections.abc import Iterator
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from xml.etree.ElementTree import Element, ElementTree, indent, parse

from aeb_sumo.scenarios import Scenario

__all__ = ["DISTANCE", "side_by_side"]

DISTANCE = 1000.0
"""Between two copies [m], our assumption: no sensor sees as far."""

_NAMES = ("id", "from", "to", "via", "incLanes", "intLanes", "edges", "route")
"""Attributes that hold names of parts of a net, of routes or of flows, one or several with spaces between."""

_SHARED = ("location", "vType")
"""Elements that are there once, however many copies there are."""


def side_by_side(scenario: Scenario, count: int, folder: Path) -> Scenario:
    """The scenario with its network and its demand `count` times.

    Args:
        scenario: its options name one net file and one route file; the net has no traffic lights.
        count: how many; the ids of copy i begin with "i/".
        folder: for the files, which must be there as long as the scenario is used.
    """
    options = list(scenario.options)
    for option, transform in (("--net-file", _net), ("--route-files", _repeated)):
        place = options.index(option) + 1
        root = parse(options[place]).getroot()  # noqa: S314 - a file of the library itself
        target = folder / f"copies{option}.xml"
        _write(transform(root, count), target)
        options[place] = str(target)
    return replace(scenario, options=tuple(options))


def _repeated(root: Element, count: int) -> Element:
    """All elements as often as there are copies; those of a kind stay together, for SUMO wants edges first."""
    result = Element(root.tag, root.attrib)
    kinds = dict.fromkeys(child.tag for child in root)
    for kind in kinds:
        same = root.findall(kind)
        result.extend(same if kind in _SHARED else _copies(same, count))
    return result


def _copies(elements: list[Element], count: int) -> Iterator[Element]:
    for number in range(count):
        for element in elements:
            one = deepcopy(element)
            for part in one.iter():
                _rename(part, f"{number}/")
                _move(part, number * DISTANCE)
            yield one


def _net(root: Element, count: int) -> Element:
    net = _repeated(root, count)
    (location,) = net.findall("location")
    left, low, right, high = map(float, location.attrib["convBoundary"].split(","))
    location.set("convBoundary", f"{left:.2f},{low:.2f},{right:.2f},{high + (count - 1) * DISTANCE:.2f}")
    return net


def _rename(part: Element, prefix: str) -> None:
    for name in _NAMES:
        if name in part.attrib:
            # A colon in front marks what is inside a junction.
            ids = part.attrib[name].split()
            part.set(name, " ".join(f":{prefix}{i[1:]}" if i.startswith(":") else prefix + i for i in ids))


def _move(part: Element, up: float) -> None:
    if "shape" in part.attrib:
        points = [[float(value) for value in point.split(",")] for point in part.attrib["shape"].split()]
        part.set("shape", " ".join(",".join(f"{v:.2f}" for v in (x, y + up, *z)) for x, y, *z in points))
    if "y" in part.attrib:
        part.set("y", f"{float(part.attrib['y']) + up:.2f}")


def _write(root: Element, path: Path) -> None:
    indent(root)
    ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)
