"""Reading the world into arrays."""

import libsumo
import numpy as np

from aeb_sumo.compiled import kernel
from aeb_sumo.soa import Bools, Floats, Ints, fitted
from aeb_sumo.world.kinds import VClasses, mass

__all__ = ["Traffic"]


_MOTION = ("x", "y", "heading", "speed")
_OTHER = (
    "accel", "length", "width", "min_gap", "fastest", "brakes", "mass", "serial", "vulnerable", "driven", "wheeled",
    "here", "fresh", "sudden", "followed_at", "read_at",
)  # fmt: skip
_ARRAYS = (*_MOTION, *("old_" + name for name in _MOTION), *_OTHER)
_NEVER = -10  # no step, nor the one before it


class Traffic:
    """All vehicles of the running simulation, as arrays over slots.

    A vehicle has one slot from departure to arrival, so other parts of the platform can keep arrays of their own
    beside these; a slot is used again after its vehicle has left.

    Reading costs as much as simulating, so only those are read whom somebody asks for: `read` for whoever looks on,
    `follow` for whoever takes part in what happens. What is in the arrays of others is of the step when they were read
    last. Those who are followed from one step to the next have an earlier state.

    Attributes:
        ids, vclass, vtype: per slot, strings.
        slot: vehicle id -> slot.
        walkers: slots of the persons on foot (`aeb_sumo.world.walkers`), who are read in every step.
        present: slots of the vehicles on the network now, rising.
        departed, left: slots of vehicles that came and (slots, ids) that went with the last step.
        arrived: ids of vehicles that reached their destination with the last step; others that left were taken away.
        x, y: centre of the front bumper [m].
        heading: mathematical angle [rad], 0 along +x, counter-clockwise.
        speed, accel: [m/s], [m/s2]; the acceleration is that of the last step.
        old_x ... old_speed: the same a step earlier.
        length, width, min_gap, mass: [m], [m], [m], [kg].
        fastest: the highest speed it can reach [m/s].
        brakes: how hard SUMO's driver may brake unless there is an emergency [m/s2].
        serial: running number of the vehicle or walker, from 1, which tells it from others that had its slot.
        vulnerable: a two-wheeler or a pedestrian.
        driven: a motor vehicle with a driver.
        wheeled: no walker.
        here: on the network now.
        fresh: just inserted, or back from a teleport.
        sudden: followed since this step only, or fresh: no earlier state, where the old position equals the new.
        followed_at, read_at: numbers of the steps when that happened last.
        teleports: how often a vehicle has been taken off the road to be put back elsewhere.
        inserted: how many vehicles have departed.
        dt: step length [s].
        step: number of the last step.
        every: everyone is read in every step.
    """

    def __init__(self, dt: float, *, every: bool = False) -> None:
        self.dt = dt
        self.every = every
        self.step = 0
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
        self.fastest: Floats = none
        self.brakes: Floats = none
        self.mass: Floats = none
        self.serial: Floats = none
        self.vulnerable: Bools = np.zeros(0, np.bool_)
        self.driven: Bools = np.zeros(0, np.bool_)
        self.wheeled: Bools = np.zeros(0, np.bool_)
        self.here: Bools = np.zeros(0, np.bool_)
        self.fresh: Bools = np.zeros(0, np.bool_)
        self.sudden: Bools = np.zeros(0, np.bool_)
        self.followed_at: Ints = np.zeros(0, np.int64)
        self.read_at: Ints = np.zeros(0, np.int64)
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
        self._expected = 0  # SUMO's count of all that is still to come to an end, flows and persons, too
        self._free: list[int] = []
        self._refreshed: list[int] = []
        self._away: set[str] = set()

    @property
    def capacity(self) -> int:
        """Length of the arrays: slots in use and to spare."""
        return len(self.x)

    @property
    def followed(self) -> Bools:
        """Per slot, whether it is followed in this step."""
        result: Bools = self.followed_at == self.step
        return result

    def rear(self, slots: Ints) -> tuple[Floats, Floats]:
        """(n,) x and (n,) y of the centre of the rear bumpers of those in these slots [m]."""
        heading, length = self.heading[slots], self.length[slots]
        return self.x[slots] - length * np.cos(heading), self.y[slots] - length * np.sin(heading)

    def observe(self) -> None:
        """See who is there after a step."""
        self.step += 1
        self.departed, self.left = [], []
        if self._refreshed:
            self.fresh[self._refreshed] = False
            self._refreshed = []
        sim = libsumo.simulation
        came, went = sim.getDepartedNumber(), sim.getArrivedNumber()
        jumps = sim.getStartingTeleportNumber() or sim.getEndingTeleportNumber()
        missed, before, self._expected = False, self._expected, sim.getMinExpectedNumber()
        if self._expected != before + sim.getLoadedNumber() - went:  # somebody may have been taken away without a word
            missed = libsumo.vehicle.getIDCount() != len(self.present) + came - went  # which costs a list of all ids
        if came or went or jumps or missed or self._away:
            if jumps or missed or self._away or not self._updated():
                self._compared()
            self.present = (self.here & self.wheeled).nonzero()[0]
        if jumps:
            self._mark_teleports()
        if self.every:
            self.read(self.present)

    def taken_away(self, vehicle: str) -> None:
        """A vehicle has been removed by command, which SUMO tells in no list."""
        self._away.add(vehicle)

    def read(self, slots: Ints) -> None:
        """Bring the arrays up to date for the vehicles on the road in these slots."""
        rows = slots[self.read_at[slots] != self.step]
        if not len(rows):
            return
        get, ids = libsumo.vehicle, self.ids
        position, angle, speed, accel = get.getPosition, get.getAngle, get.getSpeed, get.getAcceleration
        state = []
        for vehicle in [ids[slot] for slot in rows.tolist()]:
            state += position(vehicle)
            state += angle(vehicle), speed(vehicle), accel(vehicle)
        now = np.array(state).reshape(-1, 5)
        _take_in(
            rows, now, np.radians(90.0 - now[:, 2]), self.step, self.dt, self.read_at, self.x, self.y, self.heading,
            self.speed, self.accel, self.old_x, self.old_y, self.old_heading, self.old_speed,
        )  # fmt: skip

    def follow(self, slots: Ints) -> None:
        """Read the vehicles on the road in these slots, and know in the next step where they were in this one.

        Whether somebody else looks on (`read`, `every`) makes no difference.
        """
        self.read(slots)
        _take_up(
            slots, self.step, self.fresh, self.followed_at, self.sudden, self.x, self.y, self.heading, self.speed,
            self.accel, self.old_x, self.old_y, self.old_heading, self.old_speed,
        )  # fmt: skip

    def _updated(self) -> bool:
        """Take in who departed and arrived by SUMO's lists; False if they do not tell all."""
        arrived = libsumo.simulation.getArrivedIDList()
        departed = libsumo.simulation.getDepartedIDList()
        if not (self.slot.keys() >= set(arrived)) or not self.slot.keys().isdisjoint(departed):
            return False
        self.arrived = frozenset(arrived)
        for vehicle in arrived:
            self._dropped(vehicle)
        for vehicle in departed:
            self._entered(vehicle)
        return True

    def _compared(self) -> None:
        """Take in who came and went by comparing all with those of the step before."""
        now = libsumo.vehicle.getIDList()
        listed = set(now)
        gone = [v for v, slot in self.slot.items() if v not in listed and (self.here[slot] or v in self._away)]
        if gone:
            teleporting = set(libsumo.vehicle.getTeleportingIDList())
            self.arrived = frozenset(libsumo.simulation.getArrivedIDList())
            for vehicle in gone:
                self.here[self.slot[vehicle]] = False
                if vehicle not in teleporting:
                    self._dropped(vehicle)
            self._away = {v for v in gone if v in teleporting}
        else:
            self._away = set()
        for vehicle in now:
            if vehicle not in self.slot or not self.here[self.slot[vehicle]]:
                self._entered(vehicle)

    def _entered(self, vehicle: str) -> None:
        slot = self.slot[vehicle] if vehicle in self.slot else self._admit(vehicle)
        self.here[slot] = True
        self.refresh(slot)

    def _dropped(self, vehicle: str) -> None:
        slot = self.slot.pop(vehicle)
        self.here[slot] = False
        self.left.append((slot, vehicle))

    def refresh(self, slot: int) -> None:
        """Whoever is in a slot has no earlier state."""
        self.fresh[slot] = True
        self._refreshed.append(slot)

    def _mark_teleports(self) -> None:
        """A teleport can begin and end in the same step: the vehicle never leaves SUMO's list, but it has jumped."""
        started = libsumo.simulation.getStartingTeleportIDList()
        self.teleports += len(started)
        for vehicle in (*started, *libsumo.simulation.getEndingTeleportIDList()):
            if vehicle in self.slot:
                self.refresh(self.slot[vehicle])

    def _admit(self, vehicle: str) -> int:
        get = libsumo.vehicle
        vclass, vtype = get.getVehicleClass(vehicle), get.getTypeID(vehicle)
        slot = self.admit(vehicle, vclass, vtype, length=get.getLength(vehicle), width=get.getWidth(vehicle))
        self.slot[vehicle] = slot
        self.min_gap[slot], self.fastest[slot] = get.getMinGap(vehicle), get.getMaxSpeed(vehicle)
        self.brakes[slot] = get.getDecel(vehicle)
        self.wheeled[slot] = True
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
        self.length[slot], self.width[slot] = length, width
        self.min_gap[slot] = self.fastest[slot] = self.brakes[slot] = 0.0
        self.wheeled[slot] = False
        self.read_at[slot] = self.followed_at[slot] = _NEVER
        self.mass[slot] = mass(vclass)
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


@kernel
def _take_in(
    rows: Ints, now: Floats, heading_now: Floats, step: int, dt: float, read_at: Ints, x: Floats, y: Floats,
    heading: Floats, speed: Floats, accel: Floats, old_x: Floats, old_y: Floats, old_heading: Floats, old_speed: Floats,
) -> None:  # fmt: skip
    """What has been read of these, (n, 5) of position, SUMO's angle, speed and acceleration; what was is old now."""
    for k in range(len(rows)):
        slot = rows[k]
        if read_at[slot] != step:  # not twice: who is named twice has one state
            read_at[slot] = step
            old_x[slot], old_y[slot], old_heading[slot] = x[slot], y[slot], heading[slot]
            x[slot], y[slot], heading[slot] = now[k, 0], now[k, 1], heading_now[k]
            speed[slot], accel[slot] = now[k, 3], now[k, 4]
            old_speed[slot] = speed[slot] - accel[slot] * dt


@kernel
def _take_up(
    slots: Ints, step: int, fresh: Bools, followed_at: Ints, sudden: Bools, x: Floats, y: Floats, heading: Floats,
    speed: Floats, accel: Floats, old_x: Floats, old_y: Floats, old_heading: Floats, old_speed: Floats,
) -> None:  # fmt: skip
    """Follow these, who have been read; who was not followed a step ago has no earlier state."""
    for slot in slots:
        new = followed_at[slot] < step - 1 or fresh[slot]
        if followed_at[slot] < step:
            sudden[slot] = False
        if new:
            sudden[slot] = True
            old_x[slot], old_y[slot], old_heading[slot] = x[slot], y[slot], heading[slot]
            if fresh[slot]:
                old_speed[slot], accel[slot] = speed[slot], 0.0
        followed_at[slot] = step
