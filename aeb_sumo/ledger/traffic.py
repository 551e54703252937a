"""Exposure and traffic: distance, time, flow, speed and delay by vehicle class."""

from typing import Any

import numpy as np

from aeb_sumo.ledger.queues import Queues
from aeb_sumo.ledger.rows import Rows
from aeb_sumo.soa import Bools, Floats, Ints, fitted
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.surroundings import pending

__all__ = ["TrafficBook"]

_SAMPLE = 1.0  # s between two looks at queues
_COUNTS = ("departed", "arrived", "removed", "stops", "discharged")
_SUMS = ("distance_m", "time_s", "travel_time_s", "delay_s", "standing_s", "blocked_s", "headway_s")
_AT = {name: k for k, name in enumerate((*_COUNTS, *_SUMS))}


class TrafficBook:
    """Book of exposure and traffic.

    Distance and time are summed over every step and vehicle; under ballistic integration a step's distance is its mean
    speed times its length.
    """

    def __init__(self, traffic: Traffic, begin: float, interval: float) -> None:
        self._traffic = traffic
        self._queues = Queues(traffic)
        self._interval = interval
        self._started = begin
        self._sampled = begin
        self._now = begin
        self._groups: dict[tuple[str, str], int] = {}
        self._group: Ints = np.zeros(0, np.int64)
        self._since: Floats = np.zeros(0)  # per slot, time of departure [s]
        self._exposure = np.zeros((0, 3))  # vehicles, distance, time
        self._current = np.zeros((0, len(_AT)))
        self._waited: dict[str, float] = {}  # by class [s]
        self.rows = Rows("traffic")

    def depart(self, slot: int, strategy: str = "") -> None:
        """A vehicle enters, with an AEB system or without."""
        key = (self._traffic.vclass[slot], strategy)
        group = self._groups.setdefault(key, len(self._groups))
        self._group = fitted(self._group, self._traffic.capacity)
        self._since = fitted(self._since, self._traffic.capacity)
        self._exposure = fitted(self._exposure, group + 1)
        self._current = fitted(self._current, group + 1)
        self._group[slot] = group
        self._since[slot] = self._now
        self._exposure[group, 0] += 1
        self._current[group, _AT["departed"]] += 1
        self._queues.depart(slot)

    def arrive(self, slot: int) -> None:
        """A vehicle reaches its destination."""
        current = self._current[self._group[slot]]
        current[_AT["arrived"]] += 1
        current[_AT["travel_time_s"]] += self._now - self._since[slot]

    def remove(self, slot: int) -> None:
        """A vehicle is taken off the road before its destination."""
        self._current[self._group[slot], _AT["removed"]] += 1

    def step(self, time: float, wrecked: Bools) -> None:
        """Book the step that ended at `time` [s]."""
        t, rows = self._traffic, self._traffic.present
        n = len(self._groups)
        if len(rows):
            group = self._group[rows]
            distance = np.where(t.fresh[rows], 0.0, (t.speed[rows] + t.old_speed[rows]) / 2 * t.dt)
            spent = np.where(t.fresh[rows], 0.0, t.dt)
            driving = ~wrecked[rows]
            for book, weights in (
                (self._exposure[:, 1], distance * driving),
                (self._exposure[:, 2], spent * driving),
                (self._current[:, _AT["distance_m"]], distance),
                (self._current[:, _AT["time_s"]], spent),
            ):
                np.add(book, np.bincount(group, weights, n), out=book)
        if time - self._sampled >= _SAMPLE - t.dt / 2:
            self._sample(time, wrecked)
        if time - self._started >= self._interval - t.dt / 2:
            self.close_interval(time)
        self._now = time

    def _sample(self, time: float, wrecked: Bools) -> None:
        """Book what is looked at once per second."""
        span, self._sampled = time - self._sampled, time
        for vclass, count in pending().items():
            self._waited[vclass] = self._waited.get(vclass, 0.0) + count * span
        rows = self._traffic.present
        if len(rows):
            group = self._group[rows]
            for name, values in self._queues.look(time, span, wrecked).items():
                self._current[:, _AT[name]] += np.bincount(group, values, len(self._groups))

    def close_interval(self, time: float) -> None:
        """End the current interval at `time` [s], if it has begun."""
        length = time - self._started
        if length <= 0:
            return
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
