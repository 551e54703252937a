"""Questions about single vehicles that only SUMO can answer."""

import libsumo
import numpy as np

from aeb_sumo.drivers.lapses import Glances
from aeb_sumo.soa import Floats, Ints, fitted
from aeb_sumo.world.observe import Traffic

__all__ = [
    "Leads", "ahead", "demanding", "lane", "lanes", "lateral_position", "lost", "next_lanes", "overlook", "pending",
    "to_end",
]  # fmt: skip

_REACH = 150.0  # m, as far as any sensor sees
_IGNORE_IDS = "junctionModel.ignoreIDs"


class Leads:
    """The vehicle ahead of each vehicle, as SUMO names it.

    Attributes:
        lead: per slot, slot of the vehicle ahead, -1 for none within 150 m.
        gap: per slot, bumper to bumper [m], `inf` for none. SUMO leaves the ego's minGap out of its answer; here it is
            back in. In and before junctions SUMO's gaps are not to be trusted (see `perception.lead.sees_lead`).
    """

    def __init__(self, traffic: Traffic) -> None:
        self._traffic = traffic
        self.lead: Ints = np.zeros(0, np.int64)
        self.gap: Floats = np.zeros(0)

    def step(self) -> None:
        """Ask for all vehicles present."""
        t = self._traffic
        self.lead, self.gap = fitted(self.lead, t.capacity), fitted(self.gap, t.capacity)
        self.lead[:], self.gap[:] = -1, np.inf
        get, ids, known = libsumo.vehicle.getLeader, t.ids, t.slot
        egos: list[int] = []
        leads: list[int] = []
        gaps: list[float] = []
        for slot in t.present.tolist():
            answer = get(ids[slot], _REACH)
            if answer is not None and answer[0] in known:
                egos.append(slot)
                leads.append(known[answer[0]])
                gaps.append(answer[1])
        ego = np.array(egos, np.int64)
        self.lead[ego], self.gap[ego] = leads, np.array(gaps) + t.min_gap[ego]


def lateral_position(t: Traffic, slots: Ints) -> Floats:
    """(n,) offset of the vehicles in these slots from the middle of their lanes, to the left [m]."""
    get = libsumo.vehicle.getLateralLanePosition
    return np.array([get(t.ids[slot]) for slot in slots.tolist()], float)


def demanding(t: Traffic, leads: Leads, slot: int, calm: Glances) -> bool:
    """Whether the driver has reason to keep his eyes on the road just now.

    He has when he brakes or speeds up, closes in on the vehicle ahead, follows it closely, or has to find a gap because
    his lane soon leads off his route; `calm` says from where on. Drivers choose calm moments to look away.
    """
    vehicle = t.ids[slot]
    if abs(t.accel[slot]) > calm.calm_accel:
        return True
    lead, gap = leads.lead[slot], leads.gap[slot]
    if lead >= 0:
        closing = t.speed[slot] - t.speed[lead]
        if gap < closing * calm.calm_ttc or gap < t.speed[slot] * calm.calm_headway:
            return True
    lane = libsumo.vehicle.getLaneID(vehicle)
    if lane.startswith(":"):
        return False
    left = {best[0]: best[1] for best in libsumo.vehicle.getBestLanes(vehicle) if best[3] != 0}
    return lane in left and bool(left[lane] - libsumo.vehicle.getLanePosition(vehicle) < calm.calm_lane)


def lane(vehicle: str) -> str:
    """Id of the lane that a vehicle's front is on."""
    return str(libsumo.vehicle.getLaneID(vehicle))


def overlook(vehicle: str, others: set[str]) -> None:
    """Let SUMO's driver of `vehicle` not see `others` at junctions; an empty set ends it."""
    libsumo.vehicle.setParameter(vehicle, _IGNORE_IDS, " ".join(sorted(others)))


def lost(t: Traffic) -> Floats:
    """Share of the present moment that each vehicle present loses, 0 to 1.

    Against driving at the speed it would drive if it were alone on its lane; who stops on schedule loses nothing.
    """
    allowed, fastest, stopped = (
        libsumo.vehicle.getAllowedSpeed, libsumo.vehicle.getMaxSpeed, libsumo.vehicle.isStopped,
    )  # fmt: skip
    shares = np.zeros(len(t.present))
    for k, slot in enumerate(t.present.tolist()):
        vehicle, speed = t.ids[slot], t.speed[slot]
        if speed > 0.1 or not stopped(vehicle):
            shares[k] = max(0.0, 1 - speed / max(min(allowed(vehicle), fastest(vehicle)), 0.1))
    return shares


def ahead(t: Traffic, slots: Ints) -> Ints:
    """(n,) slots of the vehicles ahead of those in `slots`, as SUMO names them; -1 for none within 150 m."""
    answers = (libsumo.vehicle.getLeader(t.ids[slot], _REACH) for slot in slots.tolist())
    return np.array([t.slot.get(answer[0], -1) if answer else -1 for answer in answers], np.int64)


def lanes(t: Traffic, slots: Ints) -> list[str]:
    """Lanes of the vehicles in these slots; empty for who is in a junction."""
    names = (libsumo.vehicle.getLaneID(t.ids[slot]) for slot in slots.tolist())
    return ["" if name.startswith(":") else name for name in names]


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
