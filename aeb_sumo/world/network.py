"""The network's lanes: how they connect, which of them conflict, where they lie."""

from dataclasses import dataclass
from functools import cache

import libsumo
import numpy as np

from aeb_sumo.soa import Floats

__all__ = ["Link", "Network"]


_MINOR = frozenset("m=sw")  # SUMO's letters for links without a signal that are not the major one


@dataclass(frozen=True)
class Link:
    """A connection from a lane.

    Attributes:
        to: the lane beyond the junction.
        via: the internal lanes on the way, in order.
        direction: SUMO's letter: `s`traight, `l`eft, `r`ight, `L` and `R` for partial turns, `t` for a turnaround.
        minor: there is no signal, and others have the right of way.
    """

    to: str
    via: tuple[str, ...]
    direction: str
    minor: bool


class Network:
    """Answers about lanes, remembered: the network does not change during a run."""

    def __init__(self) -> None:
        self.links = cache(self._links)
        self.foes = cache(self._foes)
        self.shape = cache(self._shape)
        self.length = cache(libsumo.lane.getLength)
        self.edge = cache(libsumo.lane.getEdgeID)

    def junction(self, lane: str) -> str:
        """The junction at the end of a lane that is not inside one."""
        return str(libsumo.edge.getToJunction(self.edge(lane)))

    def lanes(self, edge: str) -> list[str]:
        """Lanes of an edge, from the right."""
        return [f"{edge}_{k}" for k in range(libsumo.edge.getLaneNumber(edge))]

    def _links(self, lane: str) -> tuple[Link, ...]:
        result = []
        for to, _, _, _, first, state, direction, _ in libsumo.lane.getLinks(lane):
            via, internal = [], first
            while internal:
                via.append(internal)
                onward = libsumo.lane.getLinks(internal)
                internal = onward[0][4] if onward else ""
            result.append(Link(to, tuple(via), direction, state in _MINOR))
        return tuple(result)

    def _foes(self, lane: str) -> frozenset[str]:
        """Lanes inside the junction that conflict with an internal lane; none for others."""
        return frozenset(libsumo.lane.getInternalFoes(lane)) if lane.startswith(":") else frozenset()

    def _shape(self, lane: str) -> Floats:
        """(n, 2) points of the lane's centre line [m]."""
        return np.array(libsumo.lane.getShape(lane), float)
