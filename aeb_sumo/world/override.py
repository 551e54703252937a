"""Taking a vehicle out of SUMO's hands: one commanded speed per step, checked after the step, handed back cleanly."""

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
        self._modes: dict[int, tuple[int, int]] = {}
        self.braking: Ints = np.zeros(0, np.int64)

    def verify(self) -> None:
        """Compare the speeds just observed with those commanded a step ago."""
        t = self._traffic
        self._fit()
        for slot, _ in t.left:
            self._taken[slot] = False
            self._modes.pop(slot, None)
        for slot in t.departed:
            self._taken[slot] = False
            self._foot[slot] = 0.0
        rows = np.flatnonzero(self._taken & t.here & ~t.fresh)
        if not len(rows):
            return
        get, ids = libsumo.vehicle.getSpeed, t.ids
        t.speed[rows] = [get(ids[slot]) for slot in rows.tolist()]
        error = np.abs(t.speed[rows] - self._commanded[rows])
        for k in np.flatnonzero(error > _TOLERANCE).tolist():
            if libsumo.vehicle.isStopped(t.ids[rows[k]]):  # at a scheduled stop SUMO holds it, whatever is commanded
                error[k] = 0.0
        self.audit.commands += len(rows)
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
        for released in (self._taken & t.here & ~wanted).nonzero()[0].tolist():
            self._give_back(released)
        rows = wanted.nonzero()[0]
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
        command, ids = libsumo.vehicle.setSpeed, t.ids
        for slot, v in zip(rows.tolist(), speed.tolist(), strict=True):
            command(ids[slot], v)
        self._planning[rows], self._commanded[rows] = ~blind, speed

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
        for name in ("_commanded", "_taken", "_foot", "_planning"):
            setattr(self, name, fitted(getattr(self, name), n))
