"""Writes the plain-XML sources of `crossroads`: W0 without signals; north-south has priority.

python -m sumo_nets.build crossroads
"""

from pathlib import Path

from sumo_nets import plain
from sumo_nets.intersection import Intersection

INTERSECTION = Intersection(signal=False, setback=3.0)


def write(target: Path) -> None:
    """Write `crossroads.*.xml` and `crossroads.netccfg` into `target`."""
    plain.write(INTERSECTION, target, "crossroads")
