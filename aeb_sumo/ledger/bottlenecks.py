"""Capacity at bottlenecks: what comes out of a queue, wherever one stands.

A bottleneck is active where a queue stands before it and none behind it (from another source: Daganzo 1997), and what
leaves the queue then is its capacity after breakdown, the queue discharge flow. It is measured where lanes end:

* A queue *stands* before a lane while there are two or more queued vehicles (see `aeb_sumo.ledger.queues`) on a lane
  that leads to it, within 300 m of that one's end (both our assumption), in every look.
* A vehicle is *discharged* when it enters a lane on an edge of which not more than half of the vehicles are queued (our
  assumption). Its *headway* is the time since the one before entered the same lane. Both count if the queue has been
  standing since then.

Discharged vehicles by the sum of their headways is the flow per lane. Red lights count while the queue outlasts them,
so behind a signal it is the capacity where the queue never clears, and the saturation flow elsewhere. Wrecks in the
middle of a lane are no bottlenecks here (see `blocked_s`).
"""

import numpy as np

from aeb_sumo.soa import Bools, Ints, fitted
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.surroundings import lanes, next_lanes, to_end

__all__ = ["Bottlenecks"]

_END = 300.0  # m, our assumption
_QUEUE = 2  # vehicles, our assumption
_SPILLED = 0.5  # share of the vehicles on an edge, our assumption


class Bottlenecks:
    """Lanes with a queue before them, and who entered them last."""

    def __init__(self, traffic: Traffic) -> None:
        self._traffic = traffic
        self._numbers: dict[str, int] = {}  # of lanes
        self._edges: dict[str, int] = {}
        self._edge_of: list[int] = []  # by lane
        self._lane: Ints = np.zeros(0, np.int64)  # per slot, outside junctions; -1 before the first
        self._feeders: dict[str, set[int]] = {}  # lane -> those that lead to it
        self._last: dict[str, float] = {}  # lane with a queue before it -> when somebody entered it last [s]

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
        for name in names:
            if name not in self._numbers:
                self._enter(name)
        now = np.fromiter(map(self._numbers.__getitem__, names), np.int64, len(names))
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
                lane = names[k]
                if lane in self._last and not spilled[edge_of[now[k]]]:
                    headways[int(rows[k])] = time - self._last[lane]
                self._last[lane] = time
            fed = self._feeders
            self._last = {lane: last for lane, last in self._last.items() if not standing.isdisjoint(fed.get(lane, ()))}
        return headways

    def _standing(self, slots: Ints) -> set[int]:
        """Lanes with a queue at their end, of these queued vehicles."""
        near = to_end(self._traffic, slots) < _END if len(slots) else np.zeros(0, np.bool_)
        lanes, count = np.unique(self._lane[slots[near]], return_counts=True)
        return set(lanes[count >= _QUEUE].tolist())

    def _enter(self, lane: str) -> None:
        """Number a lane; one in a junction, or none, as of who parks, is -1."""
        if not lane or lane.startswith(":"):
            self._numbers[lane] = -1
            return
        number = self._numbers[lane] = len(self._edge_of)
        edge = lane.rpartition("_")[0]
        for ahead in next_lanes(lane):
            self._feeders.setdefault(ahead, set()).add(number)
        self._edge_of.append(self._edges.setdefault(edge, len(self._edges)))

    def _fit(self) -> None:
        old = len(self._lane)
        self._lane = fitted(self._lane, self._traffic.capacity)
        self._lane[old:] = -1
