"""Persons on foot: read into slots of the traffic, and where they mean to go."""

import re

import libsumo
import numpy as np

from aeb_sumo.soa import Floats
from aeb_sumo.world.network import Network
from aeb_sumo.world.observe import Traffic

__all__ = ["PREFIX", "Walkers", "fell"]

PREFIX = "person:"
"""Goes before the ids of persons: SUMO lets a person and a vehicle have the same."""

_CROSSING = re.compile(r":.+_c\d+$")  # SUMO's names of pedestrian crossings


class Walkers:
    """All persons on foot; who rides in a vehicle is none. Costs nothing where there are no persons."""

    def __init__(self, traffic: Traffic, network: Network) -> None:
        self._traffic = traffic
        self._network = network
        self._slots: dict[str, int] = {}

    def observe(self) -> None:
        """Read the state after a step, behind `Traffic.observe`."""
        if not self._slots and not libsumo.person.getIDCount():
            return
        t, get = self._traffic, libsumo.person
        on_foot = [person for person in get.getIDList() if not get.getVehicle(person)]
        for person in [p for p in self._slots if p not in set(on_foot)]:
            t.dismiss(self._slots.pop(person))
        for person in on_foot:
            if person not in self._slots:
                slot = self._slots[person] = t.admit(
                    PREFIX + person, "pedestrian", get.getTypeID(person),
                    length=get.getLength(person), width=get.getWidth(person),
                )  # fmt: skip
                t.here[slot] = True
                t.refresh(slot)
        rows = t.walkers = np.array([self._slots[p] for p in on_foot], np.int64)
        if not len(rows):
            return
        position = np.array([get.getPosition(p) for p in on_foot])
        now = {
            "x": position[:, 0],
            "y": position[:, 1],
            "heading": np.radians(90.0 - np.array([get.getAngle(p) for p in on_foot])),
            "speed": np.array([get.getSpeed(p) for p in on_foot]),
        }
        for name, value in now.items():
            array, old = getattr(t, name), getattr(t, "old_" + name)
            old[rows] = np.where(t.fresh[rows], value, array[rows])
            array[rows] = value
        t.read_at[rows] = t.followed_at[rows] = t.step
        t.accel[rows] = 0.0  # SUMO's persons start and stop at once, and their speed is noisy

    def path(self, slot: int, reach: float, spacing: float) -> Floats:
        """(n, 2) points `spacing` [m] apart that a walker will pass, as far as `reach` [m].

        Over the crossing that he is about to enter if he waits or walks beside one, otherwise straight on.
        """
        t = self._traffic
        here = np.array([t.x[slot], t.y[slot]])
        corners = [here]
        onward = libsumo.person.getNextEdge(t.ids[slot].removeprefix(PREFIX))
        if _CROSSING.match(onward):
            shape = self._network.shape(onward + "_0")
            from_end = np.hypot(*(shape[-1] - here)) < np.hypot(*(shape[0] - here))
            corners += list(shape[::-1] if from_end else shape)
        else:
            corners.append(here + reach * np.array([np.cos(t.heading[slot]), np.sin(t.heading[slot])]))
        line = np.array(corners)
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
        where = np.arange(0.0, min(reach, along[-1]) + 1e-9, spacing)
        return np.column_stack([np.interp(where, along, line[:, k]) for k in (0, 1)])


def fell(name: str) -> None:
    """Take a person, as named in `Traffic.ids`, off the road; he is gone after the next step."""
    libsumo.person.removeStages(name.removeprefix(PREFIX))
