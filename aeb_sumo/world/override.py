"""Taking a vehicle out of SUMO's hands: its speed commanded, checked after the step, and handed back cleanly."""

from dataclasses import dataclass

import libsumo
import numpy as np

from aeb_sumo.compiled import kernel
from aeb_sumo.soa import Bools, Floats, Ints, fitted
from aeb_sumo.units import G
from aeb_sumo.world.friction import Friction
from aeb_sumo.world.observe import Traffic

__all__ = ["Audit", "Override"]

_TOLERANCE = 1e-3  # m/s, between commanded and executed speed
_NO_LANE_CHANGES = 0

# Bits of SUMO's speed mode: 1 keep safe gaps, 2 and 4 keep the type's acceleration and deceleration, 8 yield at
# junctions, 16 brake for red, 32 ignore who is inside a junction.
_EXECUTE_AND_PLAN = 24
"""Execute the commanded speed, while SUMO goes on planning what its driver would do by all the rules."""
_EXECUTE_BLINDLY = 32
"""Execute the commanded speed; the driver sees nothing."""

_HARD = 2.0  # m/s2, our assumption: less than any that takes those behind by surprise
_HOLD = 10.0  # s, the longest that an acceleration is left to SUMO
_TAKE, _MODE, _HOLDS = 1, 2, 4  # what there is to do with a vehicle before it gets its command, or in its place
_PEDAL_RELEASE = 3.0  # m/s3, how fast a foot that may be off the brake is taken to leave it, our assumption


@dataclass
class Audit:
    """What became of the commands of a run.

    Attributes:
        commands: speeds commanded.
        violations: commands that SUMO did not execute within 0.001 m/s; where it holds a vehicle at a scheduled stop,
            it is right not to.
        worst: largest difference [m/s].
    """

    commands: int = 0
    violations: int = 0
    worst: float = 0.0


class Override:
    """Who drives which vehicle, and how hard.

    Three can drive: SUMO; a driver in error, with an acceleration of his own; a wreck, sliding to a stop. The AEB
    brakes on top of the first two, and never takes away from a driver who brakes harder:

        deceleration = max(AEB, driver), at most mu g

    A driver in error who keeps his acceleration is left to SUMO, which holds it exactly; what has become of that is
    checked when it ends. All others are commanded, and checked, in every step.

    What SUMO's driver wants is known one step late, and to within 3 m/s3 times the step (see `_sumo_driver`).

    Call `drive` once per step, and `verify` after the next.

    Attributes:
        audit: what became of the commands so far.
        braking: slots of those who have been commanded to brake hard for the last step.
    """

    def __init__(self, traffic: Traffic, friction: Friction) -> None:
        self._traffic = traffic
        self._friction = friction
        self.audit = Audit()
        self._commanded: Floats = np.zeros(0)
        self._taken: Bools = np.zeros(0, np.bool_)
        self._foot: Floats = np.zeros(0)
        self._planning: Bools = np.zeros(0, np.bool_)
        # Whose acceleration is held by SUMO: it, and from which speed, since which step and until which.
        self._holding: Bools = np.zeros(0, np.bool_)
        self._held: Floats = np.zeros(0)
        self._since: Ints = np.zeros(0, np.int64)
        self._until: Ints = np.zeros(0, np.int64)
        self._modes: dict[int, tuple[int, int]] = {}
        self.braking: Ints = np.zeros(0, np.int64)

    def verify(self) -> None:
        """Compare the speeds just observed with those commanded a step ago."""
        t = self._traffic
        self._fit()
        for slot, _ in t.left:
            self._taken[slot] = self._holding[slot] = False
            self._modes.pop(slot, None)
        if self._holding.any():
            self._holding &= ~t.fresh  # a teleport is no matter of speeds
        for slot in t.departed:
            self._taken[slot] = False
            self._foot[slot] = 0.0
        rows = (self._taken & t.here).nonzero()[0]
        rows = rows[~(self._holding[rows] | t.fresh[rows])]
        self.audit.commands += len(rows)
        self._compare(rows, self._commanded[rows])

    def _compare(self, rows: Ints, expected: Floats) -> None:
        """Whether the vehicles in these slots drive at the speeds [m/s] that commands should have led to."""
        get, ids, speed, audit = libsumo.vehicle, self._traffic.ids, self._traffic.speed, self.audit
        for slot, should in zip(rows.tolist(), expected.tolist(), strict=True):
            speed[slot] = now = get.getSpeed(ids[slot])
            error = abs(now - should)
            if error > _TOLERANCE:
                if get.isStopped(ids[slot]):  # at a scheduled stop SUMO holds it, whatever is commanded
                    continue
                audit.violations += 1
            audit.worst = max(audit.worst, error)

    def drive(self, *, erring: Bools, erring_accel: Floats, aeb: Floats, wrecked: Bools, wreck_speed: Floats) -> None:
        """Command every vehicle that is not SUMO's alone; give back those that are again.

        All arguments are per slot.

        Args:
            erring: the driver is in error and does not do what SUMO's would.
            erring_accel: what he does instead, signed [m/s2].
            aeb: deceleration by the AEB's brake in the coming step, 0 for none [m/s2].
            wrecked: has crashed.
            wreck_speed: speed of a wreck at the end of the coming step [m/s].
        """
        t, ids, get = self._traffic, self._traffic.ids, libsumo.vehicle
        let_go, released = _ended(
            t.here, erring, erring_accel, aeb, wrecked, self._taken, self._holding, self._held, self._until, t.step
        )
        if len(let_go):
            self._let_go(let_go)
        for slot in released.tolist():
            self._give_back(slot)
        rows, seeing = _wanted(
            t.here, erring, aeb, wrecked, wreck_speed, self._taken, self._holding, self._commanded, self._foot
        )
        for slot in seeing.tolist():
            self._foot[slot] = self._sumo_driver(slot)
        self.braking = (self._holding & t.here & (self._held < -_HARD)).nonzero()[0]
        if not len(rows):
            return
        hard, todo = _commands(
            rows, self._foot, self._friction.at(rows) * G, erring, erring_accel, aeb, wrecked, wreck_speed, t.speed,
            t.step, t.dt, self._taken, self._planning, self._commanded, self._holding, self._held, self._since,
            self._until,
        )  # fmt: skip
        self.braking = np.append(self.braking, hard)
        speeds = self._commanded[rows].tolist()
        for slot, speed, what in zip(rows.tolist(), speeds, todo.tolist(), strict=True):
            vehicle = ids[slot]
            if what & _TAKE:
                self._take(slot, vehicle)
            if what & _MODE:
                get.setSpeedMode(vehicle, _EXECUTE_AND_PLAN if self._planning[slot] else _EXECUTE_BLINDLY)
            if what & _HOLDS:  # one command in place of one in every step
                get.setAcceleration(vehicle, float(self._held[slot]), _HOLD)
            else:
                get.setSpeed(vehicle, speed)

    def _let_go(self, rows: Ints) -> None:
        """What has been held ends now: see where it has led."""
        steps = self._traffic.step - self._since[rows]
        self.audit.commands += int(steps.sum())
        self._compare(rows, self._commanded[rows] + self._held[rows] * steps * self._traffic.dt)
        self._holding[rows] = False
        self._commanded[rows] = self._traffic.speed[rows]

    def _sumo_driver(self, slot: int) -> float:
        """Deceleration that SUMO's own driver wants, who sees where he goes, >= 0 [m/s2].

        A vehicle not yet taken shows it by what it did. For one under command, SUMO says what speed its driver would
        have chosen, but never more than the command: below the command he brakes harder, and by that much; at the
        command his foot may be anywhere up to it, so it comes off the pedal slowly, until the command is less than he
        wants and he shows again.
        """
        t, foot = self._traffic, float(self._foot[slot])
        if not self._taken[slot]:
            return max(0.0, -float(t.accel[slot]))
        if not self._planning[slot]:
            return foot
        planned = float(libsumo.vehicle.getSpeedWithoutTraCI(t.ids[slot]))
        if planned < self._commanded[slot] - _TOLERANCE:
            return (float(t.old_speed[slot]) - planned) / t.dt
        return max(0.0, foot - _PEDAL_RELEASE * t.dt)

    def _take(self, slot: int, vehicle: str) -> None:
        get = libsumo.vehicle
        self._modes[slot] = (get.getSpeedMode(vehicle), get.getLaneChangeMode(vehicle))
        get.setLaneChangeMode(vehicle, _NO_LANE_CHANGES)
        self._taken[slot] = True

    def _give_back(self, slot: int) -> None:
        vehicle = self._traffic.ids[slot]
        speed_mode, lane_change_mode = self._modes.pop(slot)
        libsumo.vehicle.setSpeed(vehicle, -1)
        libsumo.vehicle.setSpeedMode(vehicle, speed_mode)
        libsumo.vehicle.setLaneChangeMode(vehicle, lane_change_mode)
        self._taken[slot] = False
        self._foot[slot] = 0.0

    def _fit(self) -> None:
        n = self._traffic.capacity
        if len(self._taken) == n:
            return
        for name in ("_commanded", "_taken", "_foot", "_planning", "_holding", "_held", "_since", "_until"):
            setattr(self, name, fitted(getattr(self, name), n))


@kernel
def _ended(
    here: Bools, erring: Bools, erring_accel: Floats, aeb: Floats, wrecked: Bools, taken: Bools, holding: Bools,
    held: Floats, until: Ints, step: int,
) -> tuple[Ints, Ints]:  # fmt: skip
    """Slots of those whose acceleration SUMO no longer holds, and of those who are SUMO's alone again."""
    let_go, released = np.empty(len(here), np.int64), np.empty(len(here), np.int64)
    m = n = 0
    for slot in range(len(here)):
        if here[slot] and taken[slot]:
            alone = erring[slot] and aeb[slot] <= 0 and not wrecked[slot]
            if holding[slot] and not (alone and erring_accel[slot] == held[slot] and until[slot] > step):
                let_go[m] = slot
                m += 1
            if not (erring[slot] or aeb[slot] > 0 or wrecked[slot]):
                released[n] = slot
                n += 1
    return let_go[:m], released[:n]


@kernel
def _wanted(
    here: Bools, erring: Bools, aeb: Floats, wrecked: Bools, wreck_speed: Floats, taken: Bools, holding: Bools,
    commanded: Floats, foot: Floats,
) -> tuple[Ints, Ints]:  # fmt: skip
    """Slots of those who need a command, and of those among them whose drivers see; the foot of others is off."""
    rows, seeing = np.empty(len(here), np.int64), np.empty(len(here), np.int64)
    m = n = 0
    for slot in range(len(here)):
        if not here[slot] or holding[slot] or not (erring[slot] or aeb[slot] > 0 or wrecked[slot]):
            continue
        if wrecked[slot] and taken[slot] and commanded[slot] == 0 and wreck_speed[slot] <= 0:
            continue  # a wreck that stands goes on standing
        rows[m] = slot
        m += 1
        if erring[slot] or wrecked[slot]:
            foot[slot] = 0.0
        else:
            seeing[n] = slot
            n += 1
    return rows[:m], seeing[:n]


@kernel
def _commands(
    rows: Ints, foot: Floats, most: Floats, erring: Bools, erring_accel: Floats, aeb: Floats, wrecked: Bools,
    wreck_speed: Floats, speed: Floats, step: int, dt: float, taken: Bools, planning: Bools, commanded: Floats,
    holding: Bools, held: Floats, since: Ints, until: Ints,
) -> tuple[Ints, Ints]:  # fmt: skip
    """What these are commanded; slots of those who brake hard, and (n,) what else there is to do."""
    hard, todo = np.empty(len(rows), np.int64), np.zeros(len(rows), np.int64)
    n = 0
    for k in range(len(rows)):
        slot = rows[k]
        blind = erring[slot] or wrecked[slot]
        driver = -erring_accel[slot] if erring[slot] else foot[slot]
        decel = np.minimum(np.maximum(aeb[slot], driver) if aeb[slot] > 0 else driver, most[k])
        if decel > _HARD:
            hard[n] = slot
            n += 1
        if not taken[slot]:
            todo[k] |= _TAKE
        if not taken[slot] or planning[slot] == blind:  # whatever its speed mode was, it is set now
            todo[k] |= _MODE
        planning[slot] = not blind
        commanded[slot] = wreck_speed[slot] if wrecked[slot] else np.maximum(speed[slot] - decel * dt, 0.0)
        if wrecked[slot] or aeb[slot] > 0 or not erring[slot]:
            continue
        if np.abs(erring_accel[slot]) * _HOLD < speed[slot] and decel == -erring_accel[slot]:
            todo[k] |= _HOLDS
            holding[slot], held[slot], commanded[slot] = True, erring_accel[slot], speed[slot]
            since[slot], until[slot] = step, step + int(_HOLD / dt)
    return hard[:n], todo
