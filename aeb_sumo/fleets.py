"""All equipped vehicles of a run, whatever system each of them has: one `Fleet` per system."""

from collections.abc import Mapping
from functools import reduce

import numpy as np

from aeb_sumo.fleet import Fleet, Target
from aeb_sumo.soa import Bools, Floats, Ints, fitted, put
from aeb_sumo.strategies.base import Demand, Phase
from aeb_sumo.targets import Targets

__all__ = ["PAUSE", "Fleets"]

PAUSE = 1.0
"""Two actions of a vehicle's AEB with less than this between them are one intervention [s], our assumption."""


class Fleets:
    """Several fleets side by side, each at work on its own slots; to the rest of a run they are one.

    A slot belongs to one of them at most and means nothing to the others, so what they all say is the sum.

    Args:
        fleets: by the name of their system, at least one.

    Attributes:
        decel: per slot, mean deceleration by the AEB's brake in the coming step [m/s2].
        demand: per slot, the demand of its strategy in the coming step.
    """

    def __init__(self, fleets: Mapping[str, Fleet]) -> None:
        self._names = ("", *fleets)
        self._fleets = tuple(fleets.values())
        self._which: Ints = np.zeros(0, np.int64)  # per slot, place of its system in `_names`
        self._withheld: dict[int, float] = {}  # slot -> when its system last wanted to act [s]
        self._add_up()

    def _add_up(self) -> None:
        self.decel: Floats = reduce(np.add, (fleet.decel for fleet in self._fleets))
        self.demand: Demand = reduce(_sum, (fleet.demand for fleet in self._fleets))

    @property
    def busy(self) -> Ints:
        """Slots of the vehicles that have to be followed whatever they meet; see `Fleet.busy`."""
        return np.concatenate([fleet.busy for fleet in self._fleets])

    @property
    def at_work(self) -> Ints:
        """See `Fleet.at_work`."""
        return np.concatenate([fleet.at_work for fleet in self._fleets])

    @property
    def equipped(self) -> Bools:
        """Per slot."""
        return self._which > 0

    def system(self, slot: int) -> str:
        """Name of the system in a slot; empty without one."""
        return self._names[int(self._which[slot])]

    def fit(self) -> None:
        """Make room for all slots; persons on foot have some, too."""
        if sum([fleet.fit() for fleet in self._fleets]):
            self._which = fitted(self._which, len(self._fleets[0].equipped))
            self._add_up()
            self._silence(list(self._withheld))

    def depart(self, slot: int, system: str, time: float) -> None:
        """A vehicle enters at `time` [s], with a system or without (empty)."""
        self.fit()
        which = self._names.index(system)
        for place, fleet in enumerate(self._fleets, 1):
            fleet.depart(slot, time, equipped=place == which)
        self._which[slot] = which

    def leave(self, slot: int) -> None:
        """A vehicle is gone."""
        for fleet in self._fleets:
            fleet.leave(slot)
        self._which[slot] = 0
        self._withheld.pop(slot, None)
        self._silence(slot)

    def step(self, time: float, disabled: Bools) -> None:
        """See `Fleet.step`."""
        for fleet in self._fleets:
            fleet.step(time, disabled)
        self._add_up()
        for slot in list(self._withheld):
            self._hold_back(slot, time)

    def withhold(self, slot: int, time: float, last: float) -> None:
        """Keep from the road what the system in a slot decides, until it has been quiet for `PAUSE`.

        The system goes on working, and knows nothing of it.

        Args:
            slot: of the vehicle.
            time: now [s].
            last: when it last acted [s]; longer ago than `PAUSE`, nothing is kept.
        """
        self._withheld[slot] = last
        self._hold_back(slot, time)

    def _hold_back(self, slot: int, time: float) -> None:
        if time - self._withheld[slot] > PAUSE:  # as the book of interventions has it: what comes now is another one
            del self._withheld[slot]
            return
        if self.decel[slot] > 0 or self.demand.phase[slot] > Phase.NONE:
            self._withheld[slot] = time
        self._silence(slot)

    def _silence(self, slots: int | list[int]) -> None:
        """The systems in these slots do nothing, as far as the rest of a run sees."""
        self.decel[slots], self.demand.decel[slots], self.demand.phase[slots] = 0.0, 0.0, Phase.NONE

    def active(self) -> list[tuple[int, Target | None]]:
        """See `Fleet.active`; in the order of the slots."""
        acting = (one for fleet in self._fleets for one in fleet.active() if one[0] not in self._withheld)
        return sorted(acting, key=lambda one: one[0])

    def targets(self, slots: Ints) -> Targets:
        """See `Fleet.targets`."""
        result = Targets.none(len(slots))
        for place, fleet in enumerate(self._fleets, 1):
            own = self._which[slots] == place
            put(result, own, fleet.targets(slots[own]))
        return result

    def friction_known(self, slots: Ints) -> Floats:
        """(n,) friction coefficient as the vehicles in these slots know it; nan without a system."""
        result = np.full(len(slots), np.nan)
        for place, fleet in enumerate(self._fleets, 1):
            own = self._which[slots] == place
            result[own] = fleet.grip.known(slots[own])
        return result


def _sum(one: Demand, two: Demand) -> Demand:
    return Demand(phase=one.phase + two.phase, decel=one.decel + two.decel)
