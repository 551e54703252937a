"""Exposure and traffic: distance, time, flow, speed and delay by vehicle class."""

from typing import Any

import numpy as np

from aeb_sumo.soa import Bools, Ints, fitted
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.surroundings import lost, pending

__all__ = ["TrafficBook"]

_SAMPLE = 1.0  # s between two looks at the allowed speed


class TrafficBook:
    """Book of exposure and traffic.

    Distance and time are summed over every step and vehicle; under ballistic integration a step's distance is its mean
    speed times its length.
    """

    def __init__(self, traffic: Traffic, begin: float, interval: float) -> None:
        self._traffic = traffic
        self._interval = interval
        self._started = begin
        self._sampled = begin
        self._groups: dict[tuple[str, str], int] = {}
        self._group: Ints = np.zeros(0, np.int64)
        self._exposure = np.zeros((0, 3))  # vehicles, distance, time
        self._current = np.zeros((0, 5))  # departed, arrived, distance, time, delay
        self.rows: list[dict[str, Any]] = []

    def depart(self, slot: int, strategy: str = "") -> None:
        """A vehicle enters, with an AEB system or without."""
        key = (self._traffic.vclass[slot], strategy)
        group = self._groups.setdefault(key, len(self._groups))
        self._group = fitted(self._group, self._traffic.capacity)
        self._exposure = fitted(self._exposure, group + 1)
        self._current = fitted(self._current, group + 1)
        self._group[slot] = group
        self._exposure[group, 0] += 1
        self._current[group, 0] += 1

    def arrive(self, slot: int) -> None:
        """A vehicle reaches its destination."""
        self._current[self._group[slot], 1] += 1

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
                (self._current[:, 2], distance),
                (self._current[:, 3], spent),
            ):
                np.add(book, np.bincount(group, weights, n), out=book)
            if time - self._sampled >= _SAMPLE - t.dt / 2:
                self._current[:, 4] += np.bincount(group, lost(t) * (time - self._sampled), n)
                self._sampled = time
        else:
            self._sampled = time
        if time - self._started >= self._interval - t.dt / 2:
            self.close_interval(time)

    def close_interval(self, time: float) -> None:
        """End the current interval at `time` [s], if it has begun."""
        length = time - self._started
        if length <= 0:
            return
        waiting = pending()
        for vclass in sorted({c for c, _ in self._groups} | set(waiting)):
            groups = [g for (c, _), g in self._groups.items() if c == vclass]
            departed, arrived, distance, spent, delay = self._current[groups].sum(0).tolist() if groups else [0.0] * 5
            self.rows.append(
                {
                    "begin_s": self._started,
                    "end_s": time,
                    "vclass": vclass,
                    "departed": int(departed),
                    "arrived": int(arrived),
                    "pending": waiting.get(vclass, 0),
                    "flow_vph": arrived / length * 3600,
                    "vehicles_mean": spent / length,
                    "distance_m": distance,
                    "time_s": spent,
                    "speed_mps": distance / spent if spent > 0 else None,
                    "delay_s": delay,
                }
            )
        self._current[:] = 0
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
