"""Capacity at bottlenecks: what comes out of a queue, wherever one stands.

A bottleneck is active where a queue stands before it and none behind it (from another source: Daganzo 1997), and what
leaves the queue then is its capacity after breakdown, the queue discharge flow. It is measured where lanes end:

* A queue *stands* at the end of a lane while there is a queued vehicle (see `aeb_sumo.ledger.queues`) within 300 m of
  it (our assumption) in every look.
* A vehicle is *discharged* when it enters the next edge of which not more than half of the vehicles are queued (our
  assumption). Its *headway* is the time since the one before left the same lane. Both count if the queue has been
  standing since then.

Discharged vehicles by the sum of their headways is the flow per lane. Red lights count while the queue outlasts them,
so before a signal it is the capacity of an oversaturated lane and the saturation flow of others. Lanes that end, and
wrecks in the middle of a lane, are not seen.
"""

import numpy as np

from aeb_sumo.soa import Bools, Ints, fitted
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.surroundings import lanes, to_end

__all__ = ["Bottlenecks"]

_END = 300.0  # m, our assumption
_SPILLED = 0.5  # share of the vehicles on an edge, our assumption


class Bottlenecks:
    """Queues at the ends of lanes, and who left them last."""

    def __init__(self, traffic: Traffic) -> None:
        self._traffic = traffic
        self._numbers: dict[str, int] = {}  # of lanes
        self._edges: dict[str, int] = {}
        self._edge_of: list[int] = []  # by lane
        self._lane: Ints = np.zeros(0, np.int64)  # per slot, outside junctions; -1 before the first
        self._last: dict[int, float] = {}  # lane with a queue -> when somebody left it, if while it stood [s]

    def depart(self, slot: int) -> None:
        """A vehicle enters."""
        self._fit()
        self._lane[slot] = -1

    def look(self, time: float, queued: Bools) -> dict[int, float]:
        """Who has been discharged at `time` [s]; per slot who is queued.

        Returns:
            Slot -> headway [s].
        """
        self._fit()
        rows = self._traffic.present
        names = lanes(self._traffic, rows)
        now = np.array([self._number(name) if name else -1 for name in names], np.int64)
        before = self._lane[rows]
        self._lane[rows] = np.where(now >= 0, now, before)
        edge_of = np.array([*self._edge_of, -1])  # the last for no lane
        moved = (now >= 0) & (before >= 0) & (edge_of[now] != edge_of[before])
        standing = self._standing(rows[(now >= 0) & queued[rows]])
        headways = {}
        if self._last or standing:
            on = edge_of[now[now >= 0]]
            slow = np.bincount(on, queued[rows[now >= 0]], len(self._edges))
            spilled = slow > _SPILLED * np.bincount(on, minlength=len(self._edges))
            for k in np.flatnonzero(moved).tolist():
                lane = int(before[k])
                if lane in self._last and not spilled[edge_of[now[k]]]:
                    headways[int(rows[k])] = time - self._last[lane]
                self._last[lane] = time
        self._last = {lane: last for lane, last in self._last.items() if lane in standing}
        return headways

    def _standing(self, slots: Ints) -> set[int]:
        """Lanes with one of these queued vehicles at their end."""
        near = to_end(self._traffic, slots) < _END if len(slots) else np.zeros(0, np.bool_)
        return set(self._lane[slots[near]].tolist())

    def _number(self, lane: str) -> int:
        number = self._numbers.get(lane)
        if number is None:
            number = self._numbers[lane] = len(self._numbers)
            edge = lane.rpartition("_")[0]
            self._edge_of.append(self._edges.setdefault(edge, len(self._edges)))
        return number

    def _fit(self) -> None:
        old = len(self._lane)
        self._lane = fitted(self._lane, self._traffic.capacity)
        self._lane[old:] = -1
