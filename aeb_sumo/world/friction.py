"""Friction of the road, where it differs from place to place."""

from collections.abc import Sequence
from dataclasses import dataclass

import libsumo
import numpy as np

from aeb_sumo.errors import InputError
from aeb_sumo.soa import Floats, Ints
from aeb_sumo.world.observe import Traffic

__all__ = ["MU_RANGE", "Friction", "Stretch"]

MU_RANGE = 0.05, 1.5
"""Friction coefficients from wet ice to the best test track, our assumption."""

_SUMO_DEFAULT = 1.0


@dataclass(frozen=True, kw_only=True)
class Stretch:
    """A piece of road with a friction coefficient of its own.

    Attributes:
        road: id of an edge or of a lane.
        mu: friction coefficient, 0.05 to 1.5.
        start, end: along its lanes [m].
    """

    road: str
    mu: float
    start: float = 0.0
    end: float = np.inf

    def __post_init__(self) -> None:
        """Raises `InputError` for a value out of range."""
        if not MU_RANGE[0] <= self.mu <= MU_RANGE[1]:
            raise InputError("friction of {} must be within {} .. {}, not {:g}".format(self.road, *MU_RANGE, self.mu))
        if not 0 <= self.start < self.end:
            raise InputError(f"friction of {self.road}: from {self.start:g} to {self.end:g} m is no stretch of road")


class Friction:
    """What the road gives each vehicle.

    The first stretch of the scenario that a vehicle's front is on; else what the network says of the lane (`friction`
    in SUMO's net files), unless that is SUMO's default of 1; else the scenario's own coefficient.
    """

    def __init__(self, traffic: Traffic, mu: float, stretches: Sequence[Stretch] = ()) -> None:
        self._traffic = traffic
        self._mu = mu
        self._by_lane: dict[str, list[Stretch]] = {}
        lanes = libsumo.lane.getIDList()
        edge = {lane: libsumo.lane.getEdgeID(lane) for lane in lanes}
        for stretch in stretches:
            own = [lane for lane in lanes if stretch.road in {lane, edge[lane]}]
            if not own:
                raise InputError(f"friction: the network has no edge or lane {stretch.road!r}")
            for lane in own:
                self._by_lane.setdefault(lane, []).append(stretch)
        for lane in lanes:
            mu = libsumo.lane.getFriction(lane)
            if mu != _SUMO_DEFAULT:
                self._by_lane.setdefault(lane, []).append(Stretch(road=lane, mu=mu))

    def at(self, slots: Ints) -> Floats:
        """(n,) friction coefficient under the vehicles in these slots."""
        result = np.full(len(slots), self._mu)
        if self._by_lane:
            ids = self._traffic.ids
            for k, slot in enumerate(slots.tolist()):
                stretches = self._by_lane.get(libsumo.vehicle.getLaneID(ids[slot]))
                if stretches is None:
                    continue
                position = libsumo.vehicle.getLanePosition(ids[slot])
                result[k] = next((s.mu for s in stretches if s.start <= position < s.end), self._mu)
        return result
