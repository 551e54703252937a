"""Reading the world into arrays."""

import libsumo
import numpy as np

from aeb_sumo.soa import Bools, Floats, Ints, fitted

__all__ = ["Traffic", "VClasses"]


class VClasses:
    """SUMO's vehicle classes, as groups."""

    CARS = frozenset({"passenger", "private", "hov", "vip", "taxi", "evehicle", "ignoring", "custom1", "custom2"})
    """Cars; "ignoring" is what scenarios give a car that may drive where others may not."""
    DRIVEN = CARS | {"delivery", "truck", "trailer", "bus", "coach", "emergency", "authority", "army"}
    """Motor vehicles with a driver who can look away."""
    HEAVY = frozenset({"truck", "trailer", "bus", "coach"})
    """Of these, heavy ones."""
    RIDERS = frozenset({"bicycle", "moped", "scooter", "motorcycle"})
    """Two-wheelers."""
    VULNERABLE = RIDERS | {"pedestrian"}
    """Nobody around them: two-wheelers and pedestrians."""
    ALL = DRIVEN | RIDERS | {
        "tram", "rail_urban", "rail", "rail_electric", "rail_fast", "ship", "container", "cable_car", "subway",
        "aircraft", "wheelchair", "drone", "pedestrian",
    }  # fmt: skip
    """All that SUMO knows."""


# Masses by class [kg]: car and e-bike from another source (evidence.md, assumption there); the rest our assumption.
_MASS = {
    "bicycle": 120.0, "scooter": 120.0, "moped": 180.0, "motorcycle": 280.0, "pedestrian": 75.0, "delivery": 3000.0,
    "emergency": 3000.0, "truck": 12000.0, "trailer": 30000.0, "bus": 14000.0, "coach": 16000.0, "tram": 40000.0,
}  # fmt: skip
_CAR_MASS = 1500.0


_MOTION = ("x", "y", "heading", "speed")
_OTHER = ("accel", "length", "width", "min_gap", "mass", "serial", "vulnerable", "driven", "here", "fresh")
_ARRAYS = (*_MOTION, *("old_" + name for name in _MOTION), *_OTHER)


class Traffic:
    """All vehicles of the running simulation, as arrays over slots.

    A vehicle has one slot from departure to arrival, so other parts of the platform can keep arrays of their own
    beside these; a slot is used again after its vehicle has left.

    Attributes:
        ids, vclass, vtype: per slot, strings.
        slot: vehicle id -> slot.
        walkers: slots of the persons on foot (`aeb_sumo.world.walkers`); nothing else here is about them.
        present: slots of the vehicles on the network now, in the order of SUMO's list.
        departed, left: slots of vehicles that came and (slots, ids) that went with the last step.
        arrived: ids of vehicles that reached their destination with the last step; others that left were taken away.
        x, y: centre of the front bumper [m].
        heading: mathematical angle [rad], 0 along +x, counter-clockwise.
        speed, accel: [m/s], [m/s2]; the acceleration is that of the last step.
        old_x ... old_speed: the same a step earlier.
        length, width, min_gap, mass: [m], [m], [m], [kg].
        serial: running number of the vehicle or walker, from 1, which tells it from others that had its slot.
        vulnerable: a two-wheeler or a pedestrian.
        driven: a motor vehicle with a driver.
        here: on the network now.
        fresh: no earlier state (just inserted, or back from a teleport): old equals new.
        teleports: how often a vehicle has been taken off the road to be put back elsewhere.
        inserted: how many vehicles have departed.
        dt: step length [s].
    """

    def __init__(self, dt: float) -> None:
        self.dt = dt
        none = np.zeros(0)
        self.x: Floats = none
        self.y: Floats = none
        self.heading: Floats = none
        self.speed: Floats = none
        self.accel: Floats = none
        self.old_x: Floats = none
        self.old_y: Floats = none
        self.old_heading: Floats = none
        self.old_speed: Floats = none
        self.length: Floats = none
        self.width: Floats = none
        self.min_gap: Floats = none
        self.mass: Floats = none
        self.serial: Floats = none
        self.vulnerable: Bools = np.zeros(0, np.bool_)
        self.driven: Bools = np.zeros(0, np.bool_)
        self.here: Bools = np.zeros(0, np.bool_)
        self.fresh: Bools = np.zeros(0, np.bool_)
        self.ids: list[str] = []
        self.vclass: list[str] = []
        self.vtype: list[str] = []
        self.slot: dict[str, int] = {}
        self.present: Ints = np.zeros(0, np.int64)
        self.walkers: Ints = np.zeros(0, np.int64)
        self.departed: list[int] = []
        self.left: list[tuple[int, str]] = []
        self.arrived: frozenset[str] = frozenset()
        self.teleports = 0
        self.inserted = 0
        self._admitted = 0
        self._free: list[int] = []
        self._listed: tuple[str, ...] = ()
        self._away: set[str] = set()

    @property
    def capacity(self) -> int:
        """Length of the arrays: slots in use and to spare."""
        return len(self.x)

    def rear(self, slots: Ints) -> tuple[Floats, Floats]:
        """(n,) x and (n,) y of the centre of the rear bumpers of those in these slots [m]."""
        heading, length = self.heading[slots], self.length[slots]
        return self.x[slots] - length * np.cos(heading), self.y[slots] - length * np.sin(heading)

    def observe(self) -> None:
        """Read the state after a step."""
        self.departed, self.left = [], []
        self.fresh[:] = False
        listed = libsumo.vehicle.getIDList()
        if listed != self._listed:
            self._update_slots(listed)
        if libsumo.simulation.getStartingTeleportNumber() or libsumo.simulation.getEndingTeleportNumber():
            self._mark_teleports()
        rows = self.present
        for name in _MOTION:
            getattr(self, "old_" + name)[rows] = getattr(self, name)[rows]
        if len(rows):
            position, angle, speed = libsumo.vehicle.getPosition, libsumo.vehicle.getAngle, libsumo.vehicle.getSpeed
            self.x[rows], self.y[rows] = np.array(list(map(position, listed))).T
            self.heading[rows] = np.radians(90.0 - np.array(list(map(angle, listed))))
            self.speed[rows] = np.array(list(map(speed, listed)))
        new = self.fresh.nonzero()[0]
        if len(new):
            for name in _MOTION:
                getattr(self, "old_" + name)[new] = getattr(self, name)[new]
        self.accel[rows] = (self.speed[rows] - self.old_speed[rows]) / self.dt

    def _update_slots(self, listed: tuple[str, ...]) -> None:
        now = set(listed)
        gone = [v for v in self._listed if v not in now]
        if gone or self._away:
            teleporting = set(libsumo.vehicle.getTeleportingIDList())
            self.arrived = frozenset(libsumo.simulation.getArrivedIDList())
            for vehicle in [*gone, *sorted(self._away)]:
                self.here[self.slot[vehicle]] = False
                if vehicle not in teleporting and vehicle not in now:
                    self.left.append((self.slot.pop(vehicle), vehicle))
            self._away = {v for v in {*self._away, *gone} if v in teleporting}
        for vehicle in listed:
            slot = self.slot[vehicle] if vehicle in self.slot else self._admit(vehicle)
            if not self.here[slot]:
                self.here[slot] = self.fresh[slot] = True
        self._listed = listed
        self.present = np.array([self.slot[v] for v in listed], np.int64)

    def _mark_teleports(self) -> None:
        """A teleport can begin and end in the same step: the vehicle never leaves SUMO's list, but it has jumped."""
        started = libsumo.simulation.getStartingTeleportIDList()
        self.teleports += len(started)
        for vehicle in (*started, *libsumo.simulation.getEndingTeleportIDList()):
            if vehicle in self.slot:
                self.fresh[self.slot[vehicle]] = True

    def _admit(self, vehicle: str) -> int:
        get = libsumo.vehicle
        vclass, vtype = get.getVehicleClass(vehicle), get.getTypeID(vehicle)
        slot = self.admit(vehicle, vclass, vtype, length=get.getLength(vehicle), width=get.getWidth(vehicle))
        self.slot[vehicle] = slot
        self.min_gap[slot] = get.getMinGap(vehicle)
        self.departed.append(slot)
        self.inserted += 1
        return slot

    def admit(self, name: str, vclass: str, vtype: str, *, length: float, width: float) -> int:
        """A slot for a new road user of some length and width [m], with all that does not change while it is there."""
        if self._free:
            slot = self._free.pop()
        else:
            slot = len(self.ids)
            for names in (self.ids, self.vclass, self.vtype):
                names.append("")
            if slot >= self.capacity:
                for array in _ARRAYS:
                    setattr(self, array, fitted(getattr(self, array), max(64, 2 * slot)))
        self.ids[slot], self.vclass[slot], self.vtype[slot] = name, vclass, vtype
        self.length[slot], self.width[slot], self.min_gap[slot] = length, width, 0.0
        self.mass[slot] = _MASS.get(vclass, _CAR_MASS)
        self.vulnerable[slot] = vclass in VClasses.VULNERABLE
        self.driven[slot] = vclass in VClasses.DRIVEN
        self._admitted += 1
        self.serial[slot] = self._admitted
        return slot

    def dismiss(self, slot: int) -> None:
        """The road user in a slot given by `admit` is gone."""
        self.here[slot] = False
        self._free.append(slot)

    def release_slots(self) -> None:
        """Let the slots in `left` be used again; called when everyone has closed their books on them."""
        self._free.extend(slot for slot, _ in self.left)
