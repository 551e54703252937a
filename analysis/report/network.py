"""The shape of a road network, from SUMO's .net.xml; SUMO itself is not needed."""

import gzip
import zlib
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

__all__ = ["lanes"]

_GZIP = b"\x1f\x8b"


def lanes(path: Path) -> list[NDArray[np.float64]] | None:
    """Centre lines of all lanes, in the network's coordinates; None where the file cannot be read as a network.

    Args:
        path: of a .net.xml, also packed by gzip.

    Returns:
        One array (points, 2) of x and y per lane [m].
    """
    found = []
    try:
        with path.open("rb") as file:
            packed = file.read(2) == _GZIP
        with gzip.open(path) if packed else path.open("rb") as file:
            for _, element in ElementTree.iterparse(file):  # noqa: S314 - the file that SUMO ran on
                if element.tag == "lane":
                    points = [point.split(",")[:2] for point in element.get("shape", "").split()]
                    if len(points) > 1:
                        found.append(np.array(points, dtype=float))
                elif element.tag in {"edge", "junction", "connection"}:
                    element.clear()
    except (OSError, EOFError, ElementTree.ParseError, ValueError, zlib.error):
        return None
    return found or None
