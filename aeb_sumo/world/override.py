"""Taking a vehicle out of SUMO's hands: its speed commanded, checked after the step, and handed back cleanly."""

from dataclasses import dataclass

import libsumo
import numpy as np

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
        rows = (self._taken & ~self._holding & t.here & ~t.fresh).nonzero()[0]
        if len(rows):
            self._compare(rows, self._commanded[rows], len(rows))

    def _compare(self, rows: Ints, expected: Floats, commands: int) -> None:
        """Whether the vehicles in these slots drive at the speeds [m/s] that so many commands should have led to."""
        get, ids, t = libsumo.vehicle.getSpeed, self._traffic.ids, self._traffic
        t.speed[rows] = [get(ids[slot]) for slot in rows.tolist()]
        error = np.abs(t.speed[rows] - expected)
        for k in (error > _TOLERANCE).nonzero()[0].tolist():
            if libsumo.vehicle.isStopped(ids[rows[k]]):  # at a scheduled stop SUMO holds it, whatever is commanded
                error[k] = 0.0
        self.audit.commands += commands
        self.audit.violations += int(np.count_nonzero(error > _TOLERANCE))
        self.audit.worst = max(self.audit.worst, float(error.max(initial=0.0)))

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
        t, dt = self._traffic, self._traffic.dt
        wanted = t.here & (erring | (aeb > 0) | wrecked)
        alone = erring & (aeb <= 0) & ~wrecked
        held = self._holding & alone & (erring_accel == self._held) & (self._until > t.step)
        let_go = (self._holding & t.here & ~held).nonzero()[0]
        if len(let_go):
            self._let_go(let_go)
        for released in (self._taken & t.here & ~wanted).nonzero()[0].tolist():
            self._give_back(released)
        # A wreck that stands goes on standing.
        stands = wrecked & self._taken & (self._commanded == 0) & (wreck_speed <= 0)
        rows = (wanted & ~held & ~stands).nonzero()[0]
        self.braking = rows[:0]
        if not len(rows):
            return
        blind = erring[rows] | wrecked[rows]
        driver = np.where(erring[rows], -erring_accel[rows], self._sumo_driver(rows, blind))
        decel = np.where(aeb[rows] > 0, np.maximum(aeb[rows], driver), driver)
        decel = np.minimum(decel, self._friction.at(rows) * G)
        speed = np.where(wrecked[rows], wreck_speed[rows], np.maximum(t.speed[rows] - decel * dt, 0.0))
        self.braking = rows[decel > _HARD]
        for k in (~self._taken[rows]).nonzero()[0].tolist():
            self._take(int(rows[k]), t.ids[rows[k]])
            self._planning[rows[k]] = blind[k]  # whatever its speed mode was, it is set now
        for k in (self._planning[rows] == blind).nonzero()[0].tolist():
            libsumo.vehicle.setSpeedMode(t.ids[rows[k]], _EXECUTE_BLINDLY if blind[k] else _EXECUTE_AND_PLAN)
        self._planning[rows], self._commanded[rows] = ~blind, speed
        steady = alone[rows] & (np.abs(erring_accel[rows]) * _HOLD < t.speed[rows]) & (decel == -erring_accel[rows])
        if steady.any():
            self._hold(rows[steady], erring_accel[rows[steady]])
            rows, speed = rows[~steady], speed[~steady]
        command, ids = libsumo.vehicle.setSpeed, t.ids
        for slot, v in zip(rows.tolist(), speed.tolist(), strict=True):
            command(ids[slot], v)

    def _hold(self, rows: Ints, accel: Floats) -> None:
        """Let SUMO hold the accelerations [m/s2] of these: one command in place of one in every step."""
        t, command = self._traffic, libsumo.vehicle.setAcceleration
        for slot, a in zip(rows.tolist(), accel.tolist(), strict=True):
            command(t.ids[slot], a, _HOLD)
        self._holding[rows], self._held[rows], self._commanded[rows] = True, accel, t.speed[rows]
        self._since[rows], self._until[rows] = t.step, t.step + int(_HOLD / t.dt)

    def _let_go(self, rows: Ints) -> None:
        """What has been held ends now: see where it has led."""
        steps = self._traffic.step - self._since[rows]
        rows, steps = rows[steps > 0], steps[steps > 0]
        self._compare(rows, self._commanded[rows] + self._held[rows] * steps * self._traffic.dt, int(steps.sum()))
        self._holding[rows] = False
        self._commanded[rows] = self._traffic.speed[rows]

    def _sumo_driver(self, rows: Ints, blind: Bools) -> Floats:
        """Deceleration that SUMO's own driver wants, >= 0 [m/s2]; 0 for those who see nothing.

        A vehicle not yet taken shows it by what it did. For one under command, SUMO says what speed its driver would
        have chosen, but never more than the command: below the command he brakes harder, and by that much; at the
        command his foot may be anywhere up to it, so it comes off the pedal slowly, until the command is less than he
        wants and he shows again.
        """
        t = self._traffic
        self._foot[rows[blind]] = 0.0
        for slot in rows[~blind].tolist():
            if not self._taken[slot]:
                self._foot[slot] = max(0.0, -t.accel[slot])
            elif self._planning[slot]:
                planned = libsumo.vehicle.getSpeedWithoutTraCI(t.ids[slot])
                if planned < self._commanded[slot] - _TOLERANCE:
                    self._foot[slot] = (t.old_speed[slot] - planned) / t.dt
                else:
                    self._foot[slot] = max(0.0, self._foot[slot] - _PEDAL_RELEASE * t.dt)
        return self._foot[rows]

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
