"""Questions about single vehicles that only SUMO can answer."""

import libsumo
import numpy as np

from aeb_sumo.soa import Floats, Ints
from aeb_sumo.world.observe import Traffic

__all__ = ["allowed_speeds", "leaders", "must_change_lane", "overlook", "pending"]

_IGNORE_IDS = "junctionModel.ignoreIDs"


def leaders(t: Traffic, slots: Ints, reach: float) -> tuple[Ints, Floats]:
    """The vehicle ahead of each, as SUMO names it.

    Returns:
        (n,) slots, -1 for none within `reach` [m], and (n,) gaps, bumper to bumper [m]. SUMO leaves the ego's minGap
        out of its answer; here it is back in.
    """
    lead, gap = np.full(len(slots), -1, np.int64), np.full(len(slots), np.inf)
    get, ids, known = libsumo.vehicle.getLeader, t.ids, t.slot
    for k, slot in enumerate(slots.tolist()):
        answer = get(ids[slot], reach)
        if answer is not None and answer[0] in known:
            lead[k] = known[answer[0]]
            gap[k] = answer[1] + t.min_gap[slot]
    return lead, gap


def must_change_lane(vehicle: str, within: float) -> bool:
    """Whether the vehicle's lane leads it on its route for less than `within` [m]: its driver has to look for a gap."""
    lane, position = libsumo.vehicle.getLaneID(vehicle), libsumo.vehicle.getLanePosition(vehicle)
    if lane.startswith(":"):
        return False
    for best in libsumo.vehicle.getBestLanes(vehicle):
        if best[0] == lane:
            return bool(best[3] != 0 and best[1] - position < within)
    return False


def overlook(vehicle: str, others: set[str]) -> None:
    """Let SUMO's driver of `vehicle` not see `others` at junctions; an empty set ends it."""
    libsumo.vehicle.setParameter(vehicle, _IGNORE_IDS, " ".join(sorted(others)))


def allowed_speeds(t: Traffic) -> Floats:
    """What each vehicle present would drive if it were alone on its lane [m/s]."""
    allowed, fastest = libsumo.vehicle.getAllowedSpeed, libsumo.vehicle.getMaxSpeed
    ids = [t.ids[slot] for slot in t.present.tolist()]
    return np.array([min(allowed(v), fastest(v)) for v in ids])


def pending() -> dict[str, int]:
    """Vehicles that wait for a place to depart, by class."""
    waiting: dict[str, int] = {}
    for vehicle in libsumo.simulation.getPendingVehicles():
        vclass = libsumo.vehicle.getVehicleClass(vehicle)
        waiting[vclass] = waiting.get(vclass, 0) + 1
    return waiting


