"""Conflicts: how critical every encounter of two vehicles was, measured as the run goes.

Every pair that meets (see `ledger.encounters`) is followed until it is over; what did not come to matter is forgotten.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from aeb_sumo.compiled import kernel
from aeb_sumo.criticality import EVASIVE, EXPOSED, pet, time_below
from aeb_sumo.ledger.encounters import NOBODY, THREAT, crossing, following
from aeb_sumo.ledger.rows import Rows
from aeb_sumo.soa import Bools, Floats, Ints, find, joined, take
from aeb_sumo.units import G
from aeb_sumo.world.leads import Leads
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.paths import Crossings

__all__ = ["Conflicts"]

_SLIPPERY = 0.9  # of what a slippery road gives: as hard as a near-crash can be there, our assumption
_PET = 3.0  # s, our assumption; SSAM counts up to 5
_PAUSE = 1.0  # s without being a pair after which an encounter is over, our assumption
_LONGEST_PET = 5.0  # s, how long the second is waited for, from another source: the default of SSAM


# Encounters that are not over, those with names of `Pairs` as there; two values are by the columns of `slots`.
_OPEN = np.dtype(
    [
        ("key", "i8"),
        ("slots", "i8", 2),
        ("threat", "?"),
        ("begin", "f8"),  # first and last step as a pair [s]
        ("seen", "f8"),
        ("min_gap", "f8"),  # so far, as the next five
        ("min_ttc", "f8"),
        ("min_ttc2", "f8"),
        ("max_drac", "f8"),
        ("max_required", "f8"),
        ("exposed", "f8"),
        ("max_decel", "f8", 2),  # under threat [m/s2]
        ("worst", "i8"),  # who would come second, at the smallest TTC
        ("where", "f8", 4),  # front bumpers of both then [m]
        ("secondary", "?"),  # one had crashed before
        ("equipped", "u1", 2),  # with an AEB; Numba has no subarrays of booleans
        ("zone", "f8", 4),
        ("enter", "f8", 2),  # instants at which they came to where the paths cross, and left it; `inf` for not yet [s]
        ("leave", "f8", 2),
    ],
    align=True,
)


class Conflicts:
    """Book of conflicts.

    Args:
        traffic: all vehicles.
        error: names the error that the driver in one slot makes towards that in another, or is empty.
        mu: friction coefficient of the road.

    Attributes:
        rows: those that are over and came to matter.
        pairs: who met in the last step.
        hard: (k, 2) which of them braked as hard as in a near-crash: followers, and either one at crossings.
        ended: rows that the last step added without a crash.
    """

    def __init__(self, traffic: Traffic, error: Callable[[int, int], str], mu: float) -> None:
        self.rows = Rows("conflicts")
        self._traffic = traffic
        self._error = error
        self._evasive = min(EVASIVE, _SLIPPERY * mu * G)
        self._errors: dict[int, list[str]] = {}
        self.pairs = NOBODY
        self.hard = np.zeros((0, 2), np.bool_)
        self.ended: list[dict[str, Any]] = []
        self._open = np.zeros(0, _OPEN)

    def crash(self, one: int, other: int) -> None:
        """The vehicles in two slots have touched."""
        slots = self._open["slots"]
        hit = ((slots[:, 0] == one) & (slots[:, 1] == other)) | ((slots[:, 0] == other) & (slots[:, 1] == one))
        for measure in ("min_gap", "min_ttc", "min_ttc2"):
            self._open[measure][hit] = 0.0
        self._close(hit, crashed=True)

    def step(
        self,
        time: float,
        leads: Leads,
        crossings: Crossings,
        wrecked: Bools,
        equipped: Bools,
        *,
        among: Ints | None = None,
    ) -> None:
        """Book the step that ended at `time` [s].

        Args:
            time: now [s].
            leads: who is behind whom.
            crossings: whose paths cross.
            wrecked: per slot, who is a wreck.
            equipped: per slot, who has an AEB.
            among: slots of vehicles on the road whose encounters are all that matters, with those ahead and across.
        """
        t = self._traffic
        self.ended = []
        if not (len(leads.egos) or len(crossings.ego) or len(self._open)):
            self.pairs, self.hard = NOBODY, self.hard[:0]
            return
        pairs = following(t, leads, wrecked, among=among)
        if among is not None and len(crossings.ego):
            crossings = take(crossings, np.isin(crossings.ego, among) | np.isin(crossings.other, among))
        if len(crossings.ego):
            pairs = joined(pairs, crossing(t, crossings, wrecked))
        self.pairs, self.hard = pairs, np.zeros((len(pairs.key), 2), np.bool_)
        if len(pairs.key):
            rows, known = find(pairs.key, self._open["key"])
            if not known.all():
                before, new = len(self._open), ~known
                rows[new] = before + np.arange(new.sum())
                self._open = np.concatenate([self._open, np.zeros(new.sum(), _OPEN)])
                _begin(self._open, before, rows, time, pairs.key, pairs.slots, pairs.second, equipped, t.x, t.y)
            exposed = time_below(pairs.ttc, EXPOSED, dt=t.dt)
            measures = pairs.gap, pairs.ttc, pairs.ttc2, pairs.drac, pairs.required, exposed
            who = pairs.slots, pairs.second, pairs.threat, pairs.zone
            for k in _note(
                self._open, rows, time, *who, measures, self._evasive, self.hard, wrecked, t.accel, t.x, t.y
            ):
                self._note_errors(int(pairs.key[k]), *pairs.slots[k].tolist())
        approaching = _approaching(self._open, t.here)
        if len(approaching):
            t.read(approaching)
        self._close(_go_on(self._open, time, t.dt, t.speed, t.old_speed, t.length, t.here, wrecked))

    def close_all(self) -> None:
        """The run ends."""
        self._close(np.ones(len(self._open), np.bool_))

    def _note_errors(self, key: int, one: int, other: int) -> None:
        """In what error the two of an encounter are when it is at its worst."""
        made = self._errors.setdefault(key, ["", ""])
        made[:] = [self._error(one, other) or made[0], self._error(other, one) or made[1]]

    def _close(self, over: Bools, *, crashed: bool = False) -> None:
        """End encounters; rows for those that came to matter."""
        if not over.any():
            return
        closed = self._open[over].tolist()
        self._open = self._open[~over]
        t = self._traffic
        for values in closed:
            o = dict(zip(_OPEN.names or (), values, strict=True))
            errors = self._errors.pop(o["key"], ["", ""])
            crosses, enter, e, gap = o["key"] < 0, o["enter"], o["worst"], np.inf
            if crosses and np.isfinite(enter).any():
                e = int(np.argmax(enter))
                gap = float(pet(leave=o["leave"][1 - e], enter=enter[e]))
            hardest = max(o["max_decel"]) if crosses else o["max_decel"][0]
            near = bool(hardest > self._evasive)
            critical = gap < _PET or o["min_ttc"] < EXPOSED if crosses else o["min_ttc"] < THREAT
            if not (near or critical or crashed):
                continue
            one, other = o["slots"][e], o["slots"][1 - e]
            booked: dict[str, Any] = {
                "conflict_id": len(self.rows),
                "kind": "crossing" if crosses else "following",
                "ego": t.ids[one],
                "other": t.ids[other],
                "ego_vclass": t.vclass[one],
                "other_vclass": t.vclass[other],
                "ego_equipped": bool(o["equipped"][e]),
                "other_equipped": bool(o["equipped"][1 - e]),
                "begin_s": o["begin"],
                "end_s": o["seen"],
                "min_ttc_s": o["min_ttc"],
                "min_ttc2_s": o["min_ttc2"],
                "max_drac_mps2": o["max_drac"],
                "max_required_decel_mps2": o["max_required"],
                "min_gap_m": o["min_gap"],
                "pet_s": gap if np.isfinite(gap) and not crashed else None,
                "exposed_s": o["exposed"],
                "max_decel_mps2": o["max_decel"][e],
                "near_crash": near and not crashed,
                "crashed": crashed,
                "secondary": o["secondary"],
                "ego_error": errors[e],
                "other_error": errors[1 - e],
                "x_m": o["where"][2 * e],
                "y_m": o["where"][2 * e + 1],
            }
            self.rows.append(booked)
            self.ended += [] if crashed else [booked]


@kernel
def _begin(
    encounters: Any,
    before: int,
    rows: Ints,
    time: float,
    key: Ints,
    slots: Ints,
    second: Ints,
    equipped: Bools,
    x: Floats,
    y: Floats,
) -> None:
    """The pairs whose rows among the encounters were not there before."""
    for k in range(len(rows)):
        if rows[k] < before:
            continue
        o = encounters[rows[k]]
        o.key, o.begin, o.worst = key[k], time, second[k]
        o.min_gap = o.min_ttc = o.min_ttc2 = np.inf
        for column in range(2):
            slot = slots[k, column]
            o.slots[column], o.equipped[column] = slot, equipped[slot]
            o.enter[column] = o.leave[column] = np.inf
            o.where[2 * column], o.where[2 * column + 1] = x[slot], y[slot]


@kernel
def _note(
    encounters: Any,
    rows: Ints,
    time: float,
    slots: Ints,
    second: Ints,
    threat: Bools,
    zone: Floats,
    measures: tuple[Floats, ...],
    evasive: float,
    hard: Bools,
    wrecked: Bools,
    accel: Floats,
    x: Floats,
    y: Floats,
) -> list[int]:
    """Take the pairs of this step, by their rows among the encounters, down there, and who brakes hard in `hard`.

    Those who are nearer to a collision than before, and near, are returned.
    """
    worse = []
    gap, ttc, ttc2, drac, required, exposed = measures
    for k in range(len(rows)):
        o = encounters[rows[k]]
        for column in range(2):
            slot = slots[k, column]
            if wrecked[slot]:
                o.secondary = True
            elif threat[k] or o.threat:
                braking = -accel[slot] if accel[slot] < 0 else 0.0
                hard[k, column] = braking > evasive and (column == 0 or o.key < 0)
                o.max_decel[column] = max(o.max_decel[column], braking)
        if ttc[k] < o.min_ttc:
            o.worst = second[k]
            for column in range(2):
                o.where[2 * column], o.where[2 * column + 1] = x[slots[k, column]], y[slots[k, column]]
            if threat[k]:
                worse.append(k)
        o.min_gap, o.min_ttc, o.min_ttc2 = min(o.min_gap, gap[k]), min(o.min_ttc, ttc[k]), min(o.min_ttc2, ttc2[k])
        o.max_drac, o.max_required = max(o.max_drac, drac[k]), max(o.max_required, required[k])
        o.exposed += exposed[k]
        o.threat, o.seen = threat[k], time
        for column in range(4):
            o.zone[column] = zone[k, column]
    return worse


@kernel
def _approaching(encounters: Any, here: Bools) -> Ints:
    """Slots of those that have not left yet where the paths cross."""
    slots = np.empty(2 * len(encounters), np.int64)
    n = 0
    for o in encounters:
        for column in range(2):
            if o.key < 0 and np.isinf(o.leave[column]) and here[o.slots[column]]:
                slots[n] = o.slots[column]
                n += 1
    return slots[:n]


@kernel
def _go_on(
    encounters: Any,
    time: float,
    dt: float,
    speed: Floats,
    old_speed: Floats,
    length: Floats,
    here: Bools,
    wrecked: Bools,
) -> Bools:
    """Take all on to where the paths cross, also those that are no pair any more since one has left it; who is over."""
    over = np.empty(len(encounters), np.bool_)
    for k in range(len(encounters)):
        o = encounters[k]
        one, other = o.slots[0], o.slots[1]
        over[k] = time - o.seen > _PAUSE
        if o.key < 0:
            for column in range(2):
                if np.isfinite(o.leave[column]):
                    continue
                slot = o.slots[column]
                pace = (speed[slot] + old_speed[slot]) / 2
                if o.seen < time:
                    o.zone[2 * column] -= pace * dt
                    o.zone[2 * column + 1] -= pace * dt
                inside, outside = -o.zone[2 * column], -o.zone[2 * column + 1] - length[slot]
                if inside >= 0 and np.isinf(o.enter[column]):
                    o.enter[column] = time - min(inside / pace if pace > 0 else 0.0, dt)
                if outside >= 0:
                    o.leave[column] = time - min(outside / pace if pace > 0 else 0.0, dt)
            left = min(o.leave[0], o.leave[1])
            if np.isfinite(left):
                both = np.isfinite(o.enter[0]) and np.isfinite(o.enter[1])
                over[k] = both or time - left > _LONGEST_PET
        over[k] |= not (here[one] and here[other]) or (wrecked[one] and (wrecked[other] or o.key >= 0))
    return over
