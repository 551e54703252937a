"""Questions about single vehicles that only SUMO can answer."""

from dataclasses import dataclass

import libsumo
import numpy as np

from aeb_sumo.soa import Floats, Ints
from aeb_sumo.world.leads import REACH
from aeb_sumo.world.observe import Traffic

__all__ = [
    "Onward", "Trips", "ahead", "lane", "lanes", "lateral_position", "next_lanes", "overlook", "pending", "to_end",
    "trips",
]  # fmt: skip

_IGNORE_IDS = "junctionModel.ignoreIDs"


def lateral_position(t: Traffic, slots: Ints) -> Floats:
    """(n,) offset of the vehicles in these slots from the middle of their lanes, to the left [m]."""
    get = libsumo.vehicle.getLateralLanePosition
    return np.array([get(t.ids[slot]) for slot in slots.tolist()], float)


class Onward:
    """How far vehicles can stay on their lanes until they have to be on another for their routes."""

    def __init__(self, traffic: Traffic) -> None:
        self._traffic = traffic
        self._known: dict[int, tuple[str, float]] = {}  # slot -> lane, and where on it one has to have left it [m]

    def left(self, slot: int) -> float:
        """From where the vehicle in a slot is now [m]; `inf` for as far as it goes, and in junctions."""
        vehicle, get = self._traffic.ids[slot], libsumo.vehicle
        lane = get.getLaneID(vehicle)
        known, end = self._known.get(slot, ("", np.inf))
        if lane != known:
            left = {best[0]: best[1] for best in get.getBestLanes(vehicle) if best[3] != 0}
            end = left.get(lane, np.inf)
            self._known[slot] = lane, end
        return end - float(get.getLanePosition(vehicle)) if end < np.inf else np.inf

    def forget(self, slot: int) -> None:
        """The vehicle in a slot is gone."""
        self._known.pop(slot, None)


def lane(vehicle: str) -> str:
    """Id of the lane that a vehicle's front is on."""
    return str(libsumo.vehicle.getLaneID(vehicle))


def overlook(vehicle: str, others: set[str]) -> None:
    """Let SUMO's driver of `vehicle` not see `others` at junctions; an empty set ends it."""
    libsumo.vehicle.setParameter(vehicle, _IGNORE_IDS, " ".join(sorted(others)))


@dataclass(frozen=True)
class Trips:
    """How far vehicles have come, (n,) each.

    Attributes:
        speed: [m/s].
        driven: since their departure [m].
        lost: against driving at the speed they would drive if they were alone on their lanes, since then [s]; who stops
            on schedule loses nothing.
    """

    speed: Floats
    driven: Floats
    lost: Floats


def trips(t: Traffic, slots: Ints) -> Trips:
    """Of the vehicles on the road in these slots."""
    get = libsumo.vehicle
    speed, driven, lost = get.getSpeed, get.getDistance, get.getTimeLoss
    ids = [t.ids[slot] for slot in slots.tolist()]
    return Trips(*(np.fromiter(map(one, ids), float, len(ids)) for one in (speed, driven, lost)))


def ahead(t: Traffic, slots: Ints) -> Ints:
    """(n,) slots of the vehicles ahead of those in `slots`, as SUMO names them; -1 for none within 150 m."""
    answers = (libsumo.vehicle.getLeader(t.ids[slot], REACH) for slot in slots.tolist())
    return np.array([t.slot.get(answer[0], -1) if answer else -1 for answer in answers], np.int64)


def lanes(t: Traffic, slots: Ints) -> list[str]:
    """Lanes of the vehicles in these slots; those in junctions begin with a colon."""
    return [libsumo.vehicle.getLaneID(t.ids[slot]) for slot in slots.tolist()]


def next_lanes(lane: str) -> list[str]:
    """Lanes, outside junctions, that a lane leads to."""
    return [link[0] for link in libsumo.lane.getLinks(lane)]


def to_end(t: Traffic, slots: Ints) -> Floats:
    """(n,) how far it is to the end of the lane for the vehicles in these slots [m]."""
    get, length = libsumo.vehicle, libsumo.lane.getLength
    return np.array([length(get.getLaneID(v)) - get.getLanePosition(v) for v in (t.ids[s] for s in slots.tolist())])


def pending() -> dict[str, int]:
    """Vehicles that wait for a place to depart, by class."""
    waiting: dict[str, int] = {}
    for vehicle in libsumo.simulation.getPendingVehicles():
        vclass = libsumo.vehicle.getVehicleClass(vehicle)
        waiting[vclass] = waiting.get(vclass, 0) + 1
    return waiting
