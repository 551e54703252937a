"""Exposure and traffic: distance, time, flow, speed and delay by vehicle class."""

from typing import Any

import numpy as np

from aeb_sumo.ledger.queues import Queues
from aeb_sumo.ledger.rows import Rows
from aeb_sumo.soa import Bools, Floats, Ints, fitted
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.surroundings import pending, trips

__all__ = ["TrafficBook"]

_LOOK = 1.0  # s between two looks at everybody
_COUNTS = ("departed", "arrived", "removed", "stops", "discharged")
_SUMS = ("distance_m", "time_s", "travel_time_s", "delay_s", "standing_s", "blocked_s", "headway_s")
_AT = {name: k for k, name in enumerate((*_COUNTS, *_SUMS))}


class TrafficBook:
    """Book of exposure and traffic.

    Distances and delays are SUMO's own sums, read once per second, and when a vehicle crashes; what a vehicle drives
    between the last look and its leaving the network is taken to be at the pace of that look.
    """

    def __init__(self, traffic: Traffic, begin: float, interval: float) -> None:
        self._traffic = traffic
        self._queues = Queues(traffic)
        self._interval = interval
        self._started = begin
        self._looked = begin
        self._now = begin
        self._groups: dict[tuple[str, str], int] = {}
        self._group: Ints = np.zeros(0, np.int64)
        self._since: Floats = np.zeros(0)  # per slot, time of departure [s]
        # Per slot, at its last look: when that was [s], driven [m] and lost [s] so far, speed [m/s], share lost.
        self._seen: Floats = np.zeros(0)
        self._driven: Floats = np.zeros(0)
        self._lost: Floats = np.zeros(0)
        self._pace: Floats = np.zeros(0)
        self._share: Floats = np.zeros(0)
        self._crashed: Bools = np.zeros(0, np.bool_)
        self._exposure = np.zeros((0, 3))  # vehicles, distance, time
        self._current = np.zeros((0, len(_AT)))
        self._waited: dict[str, float] = {}  # by class [s]
        self.rows = Rows("traffic")

    def depart(self, slot: int, strategy: str = "") -> None:
        """A vehicle enters, with an AEB system or without."""
        key = (self._traffic.vclass[slot], strategy)
        group = self._groups.setdefault(key, len(self._groups))
        for name in ("_group", "_since", "_seen", "_driven", "_lost", "_pace", "_share", "_crashed"):
            setattr(self, name, fitted(getattr(self, name), self._traffic.capacity))
        self._exposure = fitted(self._exposure, group + 1)
        self._current = fitted(self._current, group + 1)
        self._group[slot] = group
        self._since[slot] = self._seen[slot] = self._traffic.dt + self._now
        self._driven[slot] = self._lost[slot] = self._pace[slot] = self._share[slot] = 0.0
        self._crashed[slot] = False
        self._exposure[group, 0] += 1
        self._current[group, _AT["departed"]] += 1
        self._queues.depart(slot)

    def arrive(self, slot: int) -> None:
        """A vehicle reaches its destination."""
        self._finish(slot)
        current = self._current[self._group[slot]]
        current[_AT["arrived"]] += 1
        current[_AT["travel_time_s"]] += self._now + self._traffic.dt - self._since[slot]

    def remove(self, slot: int) -> None:
        """A vehicle is taken off the road before its destination."""
        self._finish(slot)
        self._current[self._group[slot], _AT["removed"]] += 1

    def crash(self, slots: Ints, time: float) -> None:
        """The vehicles in these slots crash, some of them for the first time: their exposure ends."""
        self._add(slots, time)
        self._crashed[slots] = True

    def step(self, time: float, wrecked: Bools) -> None:
        """Book the step that ended at `time` [s]."""
        if time - self._looked >= _LOOK - self._traffic.dt / 2:
            self._look(time, wrecked)
        if time - self._started >= self._interval - self._traffic.dt / 2:
            self.close_interval(time)
        self._now = time

    def _look(self, time: float, wrecked: Bools) -> None:
        """Look at everybody."""
        span, self._looked = time - self._looked, time
        for vclass, count in pending().items():
            self._waited[vclass] = self._waited.get(vclass, 0.0) + count * span
        rows = self._traffic.present
        if len(rows):
            spent, shares = self._add(rows, time)
            group = self._group[rows]
            for name, values in self._queues.look(time, self._pace[rows], shares, wrecked).items():
                weights = values * spent if name in {"standing_s", "blocked_s"} else values
                self._current[:, _AT[name]] += np.bincount(group, weights, len(self._groups))

    def _add(self, slots: Ints, time: float) -> tuple[Floats, Floats]:
        """What the vehicles in these slots have driven and lost since their last looks.

        Returns:
            (n,) how long that is ago [s], and (n,) the share of it that they have lost.
        """
        now = trips(self._traffic, slots)
        spent = np.maximum(time - self._seen[slots], 0.0)
        delay = np.maximum(now.lost - self._lost[slots], 0.0)
        self._book(slots, now.driven - self._driven[slots], spent, delay)
        shares = np.divide(delay, spent, out=np.zeros(len(slots)), where=spent > 0)
        self._seen[slots], self._driven[slots], self._lost[slots] = time, now.driven, now.lost
        self._pace[slots], self._share[slots] = now.speed, shares
        return spent, shares

    def _finish(self, slot: int) -> None:
        """A vehicle has left since the last step: what it did since it was looked at last."""
        one = np.array([slot])
        spent = np.maximum(self._now - self._seen[one], 0.0)
        self._book(one, self._pace[one] * spent, spent, self._share[one] * spent)

    def _book(self, slots: Ints, distance: Floats, spent: Floats, delay: Floats) -> None:
        group, n, driving = self._group[slots], len(self._groups), ~self._crashed[slots]
        for book, weights in (
            (self._exposure[:, 1], distance * driving),
            (self._exposure[:, 2], spent * driving),
            (self._current[:, _AT["distance_m"]], distance),
            (self._current[:, _AT["time_s"]], spent),
            (self._current[:, _AT["delay_s"]], delay),
        ):
            np.add(book, np.bincount(group, weights, n), out=book)

    def close_interval(self, time: float) -> None:
        """End the current interval at `time` [s], if it has begun."""
        length = time - self._started
        if length <= 0:
            return
        if time > self._looked and len(self._traffic.present):
            self._add(self._traffic.present, time)
        waiting = pending()
        for vclass in sorted({c for c, _ in self._groups} | set(waiting) | set(self._waited)):
            groups = [g for (c, _), g in self._groups.items() if c == vclass]
            book = dict(zip(_AT, self._current[groups].sum(0).tolist(), strict=True))
            spent, distance = book["time_s"], book["distance_m"]
            self.rows.append(
                {
                    "begin_s": self._started,
                    "end_s": time,
                    "vclass": vclass,
                    "pending": waiting.get(vclass, 0),
                    "waiting_s": self._waited.get(vclass, 0.0),
                    "flow_vph": book["arrived"] / length * 3600,
                    "vehicles_mean": spent / length,
                    "speed_mps": distance / spent if spent > 0 else None,
                }
                | {name: int(book[name]) for name in _COUNTS}
                | {name: book[name] for name in _SUMS}
            )
        self._current[:] = 0
        self._waited.clear()
        self._started = time

    def exposure(self) -> list[dict[str, Any]]:
        """Rows of table `exposure`."""
        return [
            {
                "vclass": vclass,
                "equipped": bool(strategy),
                "strategy": strategy,
                "vehicles": int(self._exposure[group, 0]),
                "distance_m": float(self._exposure[group, 1]),
                "time_s": float(self._exposure[group, 2]),
            }
            for (vclass, strategy), group in sorted(self._groups.items())
        ]
