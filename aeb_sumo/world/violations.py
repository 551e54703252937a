"""Errors at junctions as they come about in the world: who does not see whom, and who rides at red."""

from dataclasses import dataclass

import libsumo
import numpy as np

from aeb_sumo.drivers.encounters import FailureToYield, Riders
from aeb_sumo.soa import Bools
from aeb_sumo.world.kinds import VClasses
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.paths import Paths
from aeb_sumo.world.sightlines import Sightlines
from aeb_sumo.world.surroundings import overlook

__all__ = ["EYE", "Violations"]

EYE = 2.0
"""How far behind the front bumper a driver's eyes are [m], our assumption."""

_STANDS = 0.5  # m/s, slower than this is standing to the eye, our assumption
_AT_LINE = 3.0  # m before a junction at which a rider's signal is read, our assumption
_RED = frozenset("rRuU")
_RIGHT = frozenset("rR")
_STOPS_AT_RED = 16  # bit of SUMO's speed mode


@dataclass
class _Encounter:
    """A driver who has to give way, and another whose path he crosses, until one of them is through."""

    fails: bool
    unaware: bool
    notice: float
    in_sight: float = 0.0
    hidden: bool = False


class Violations:
    """Drivers who do not give way, riders who rely on their right of way, riders who do not stop at red.

    All of it acts on SUMO's own drivers: they are told not to see somebody, or not to stop.
    """

    def __init__(
        self,
        traffic: Traffic,
        paths: Paths,
        yielding: FailureToYield | None,
        riders: Riders | None,
        sightlines: Sightlines,
        seed: int,
    ) -> None:
        self._traffic, self._paths, self._seed = traffic, paths, seed
        self._yielding, self._riders = yielding, riders
        self._sightlines = sightlines if yielding is not None and yielding.occlusion else None
        self._gives_way: Bools = np.zeros(0, np.bool_)  # per user of `Paths`
        self._encounters: dict[tuple[str, str], _Encounter] = {}
        self._blind: dict[str, set[str]] = {}
        self._stands: dict[tuple[str, str], float] = {}  # (unaware rider, driver) -> how long the car has stood [s]
        self.heeded: set[int] = set()
        self._modes: dict[str, tuple[str, int | None]] = {}  # rider -> junction, speed mode before; None: he stops
        self._ran: dict[str, str] = {}  # rider -> junction whose red he rode through

    def step(self, attentive: Bools) -> None:
        """Bring it all to the state just observed.

        Args:
            attentive: per slot, a warning has made the driver look.
        """
        self.heeded = set()
        for _, vehicle in self._traffic.left:
            self._modes.pop(vehicle, None)
            self._ran.pop(vehicle, None)
        if self._yielding is not None:
            self._give_way(self._yielding, attentive)
        if self._riders is not None:
            self._stop_at_red(self._riders)

    def error(self, slot: int, other: int | None) -> str:
        """The error of a road user towards another, or empty."""
        t = self._traffic
        who = t.ids[slot]
        if other is not None:
            encounter = self._encounters.get((who, t.ids[other]))
            if encounter is not None and encounter.hidden:
                return FailureToYield.name if encounter.fails else "not_seen"
        return Riders.name if who in self._ran else ""

    def _give_way(self, error: FailureToYield, attentive: Bools) -> None:
        t, turns, pairs = self._traffic, self._paths.turns, self._paths.crossings
        self._fit()
        giving = np.zeros(t.capacity, np.bool_)
        giving[turns.slot] = self._gives_way[turns.user]
        user = np.zeros(t.capacity, np.int64)
        user[turns.slot] = turns.user
        # Until the tail of one of them is through.
        ahead = (pairs.zone[:, 1] > -t.length[pairs.ego]) & (pairs.zone[:, 3] > -t.length[pairs.other])
        k = np.flatnonzero(giving[pairs.ego] & t.driven[pairs.ego] & ahead)
        ego, other = pairs.ego[k], pairs.other[k]
        seen = np.ones(len(k), np.bool_)
        if self._sightlines is not None:
            seen = self._sightlines.visible(ego, other, setback=EYE)
        over = set(self._encounters)
        for slot, other_slot, in_sight in zip(ego.tolist(), other.tolist(), seen.tolist(), strict=True):
            key = t.ids[slot], t.ids[other_slot]
            over.discard(key)
            encounter = self._encounters.get(key)
            if encounter is None:
                encounter = self._begin(error, *key, int(user[slot]), int(user[other_slot]))
            encounter.in_sight = encounter.in_sight + t.dt if in_sight else encounter.in_sight
            if attentive[slot] and encounter.fails:
                encounter.fails = False
                self.heeded.add(slot)
            hidden = encounter.fails or encounter.in_sight <= encounter.notice
            if hidden != encounter.hidden:
                encounter.hidden = hidden
                self._hide(*key, hidden=hidden)
        for key in sorted(over):
            self._end(*key)
        self._notice_standing()

    def _begin(self, error: FailureToYield, driver: str, other: str, own_user: int, other_user: int) -> _Encounter:
        t = self._traffic
        own, others = self._paths.users[own_user][0], self._paths.users[other_user][0]
        rider = t.vclass[t.slot[other]] in VClasses.RIDERS
        right = own.direction in _RIGHT
        fails = error.driver_fails(self._seed, driver, own.junction, others.approach, rider=rider, right_turn=right)
        encounter = _Encounter(
            fails=fails,
            unaware=rider and fails and error.rider_fails(self._seed, driver, other),
            notice=error.notice(self._seed, driver, other),
        )
        if encounter.unaware:
            self._hide(other, driver, hidden=True)
            self._stands[other, driver] = 0.0
        self._encounters[driver, other] = encounter
        return encounter

    def _end(self, driver: str, other: str) -> None:
        """One of them has left the crossing behind: at the next one they meet anew."""
        encounter = self._encounters.pop((driver, other))
        if encounter.hidden:
            self._hide(driver, other, hidden=False)
        if self._stands.pop((other, driver), None) is not None:
            self._hide(other, driver, hidden=False)

    def _notice_standing(self) -> None:
        """Riders see at last a car that stands in their way."""
        t = self._traffic
        for (rider, driver), stood in list(self._stands.items()):
            if t.speed[t.slot[driver]] > _STANDS:
                self._stands[rider, driver] = 0.0
            elif stood + t.dt < self._encounters[driver, rider].notice:
                self._stands[rider, driver] = stood + t.dt
            else:
                del self._stands[rider, driver]
                self._hide(rider, driver, hidden=False)

    def _stop_at_red(self, error: Riders) -> None:
        t, turns = self._traffic, self._paths.turns
        near = set()
        for slot, at, user in zip(turns.slot.tolist(), turns.at.tolist(), turns.user.tolist(), strict=True):
            if t.vclass[slot] not in VClasses.RIDERS:
                continue
            path, rider = self._paths.users[user][0], t.ids[slot]
            near.add(rider)
            if self._modes.get(rider, ("", None))[0] != path.junction:
                self._ride_on(rider)
                before = None
                if error.runs_red(self._seed, rider, path.junction):
                    before = libsumo.vehicle.getSpeedMode(rider)
                    libsumo.vehicle.setSpeedMode(rider, before & ~_STOPS_AT_RED)
                self._modes[rider] = path.junction, before
            if self._modes[rider][1] is not None and 0 <= path.junction_at - at < _AT_LINE:
                signal = libsumo.vehicle.getNextTLS(rider)[:1]
                if any(state in _RED and away < _AT_LINE + 1.0 for _, _, away, state in signal):
                    self._ran[rider] = path.junction
                else:
                    self._ran.pop(rider, None)
        for rider in set(self._modes) - near:
            self._ride_on(rider)

    def _ride_on(self, rider: str) -> None:
        """The junction lies behind."""
        _, before = self._modes.pop(rider, ("", None))
        self._ran.pop(rider, None)
        if before is not None and rider in self._traffic.slot:
            libsumo.vehicle.setSpeedMode(rider, before)

    def _hide(self, who: str, whom: str, *, hidden: bool) -> None:
        unseen = self._blind.setdefault(who, set())
        (unseen.add if hidden else unseen.discard)(whom)
        if not unseen:
            del self._blind[who]
        if who in self._traffic.slot:
            overlook(who, unseen)

    def _fit(self) -> None:
        users = self._paths.users
        if len(self._gives_way) < len(users):
            self._gives_way = np.array([path.gives_way for path, _ in users], np.bool_)
