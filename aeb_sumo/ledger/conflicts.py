"""Conflicts: how critical every encounter of two vehicles was, measured as the run goes.

Every pair that meets (see `ledger.encounters`) is followed until it is over; what did not come to matter is forgotten.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from aeb_sumo.criticality import EVASIVE, EXPOSED, pet, time_below
from aeb_sumo.ledger.encounters import THREAT, Pairs, crossing, following
from aeb_sumo.ledger.rows import Rows
from aeb_sumo.soa import Bools, Floats, Ints, find, joined, take
from aeb_sumo.units import G
from aeb_sumo.world.leads import Leads
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.paths import Crossings

__all__ = ["Conflicts"]

_NOBODY: Ints = np.zeros(0, np.int64)
_SLIPPERY = 0.9  # of what a slippery road gives: as hard as a near-crash can be there, our assumption
_PET = 3.0  # s, our assumption; SSAM counts up to 5
_PAUSE = 1.0  # s without being a pair after which an encounter is over, our assumption
_LONGEST_PET = 5.0  # s, how long the second is waited for, from another source: the default of SSAM


@dataclass(frozen=True, kw_only=True)
class _Open:
    """Encounters that are not over, (n,) or (n, 2) by the columns of `slots`; as in `Pairs` what has its names.

    Attributes:
        begin, seen: first and last step as a pair [s].
        min_gap, min_ttc, min_ttc2, max_drac, max_required, exposed: so far.
        max_decel: of both, under threat [m/s2].
        worst: who would come second, at the smallest TTC.
        where: (n, 4) front bumpers of both then [m].
        secondary: one had crashed before.
        equipped: with an AEB.
        enter, leave: instants at which they came to where the paths cross, and left it; `inf` for not yet [s].
    """

    key: Ints
    slots: Ints
    threat: Bools
    begin: Floats
    seen: Floats
    min_gap: Floats
    min_ttc: Floats
    min_ttc2: Floats
    max_drac: Floats
    max_required: Floats
    exposed: Floats
    max_decel: Floats
    worst: Ints
    where: Floats
    secondary: Bools
    equipped: Bools
    zone: Floats
    enter: Floats
    leave: Floats

    @classmethod
    def of(cls, pairs: Pairs, time: float, where: Floats, equipped: Bools) -> "_Open":
        """Encounters that begin."""
        n = len(pairs.key)
        never, none = np.full(n, np.inf), np.zeros(n)
        return cls(
            key=pairs.key,
            slots=pairs.slots,
            threat=pairs.threat,
            begin=np.full(n, time),
            seen=np.full(n, time),
            min_gap=never.copy(),
            min_ttc=never.copy(),
            min_ttc2=never.copy(),
            max_drac=none.copy(),
            max_required=none.copy(),
            exposed=none.copy(),
            max_decel=np.zeros((n, 2)),
            worst=pairs.second,
            where=where,
            secondary=np.zeros(n, np.bool_),
            equipped=equipped,
            zone=pairs.zone,
            enter=np.full((n, 2), np.inf),
            leave=np.full((n, 2), np.inf),
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
        nobody = np.zeros(0, np.bool_)
        self.pairs = following(traffic, Leads(traffic, cycle=traffic.dt, horizon=0.0), nobody)
        self.hard = np.zeros((0, 2), np.bool_)
        self.ended: list[dict[str, Any]] = []
        self._open = _Open.of(self.pairs, 0.0, np.zeros((0, 4)), np.zeros((0, 2), np.bool_))

    def crash(self, one: int, other: int) -> None:
        """The vehicles in two slots have touched."""
        slots = self._open.slots
        hit = ((slots[:, 0] == one) & (slots[:, 1] == other)) | ((slots[:, 0] == other) & (slots[:, 1] == one))
        for measure in (self._open.min_gap, self._open.min_ttc, self._open.min_ttc2):
            measure[hit] = 0.0
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
        if not (len(leads.egos) or len(crossings.ego) or len(self._open.key)):
            self.pairs, self.hard = take(self.pairs, _NOBODY), self.hard[:0]
            return
        pairs = following(t, leads, wrecked, among=among)
        if among is not None and len(crossings.ego):
            crossings = take(crossings, np.isin(crossings.ego, among) | np.isin(crossings.other, among))
        if len(crossings.ego):
            pairs = joined(pairs, crossing(t, crossings, wrecked))
        self.pairs = pairs
        at = self._rows_of(pairs, time, equipped)
        o, slots = self._open, pairs.slots
        evading = (pairs.threat | o.threat[at])[:, None] & ~wrecked[slots]
        braking = np.where(evading, np.maximum(-t.accel[slots], 0.0), 0.0)
        self.hard = braking > self._evasive
        self.hard[:, 1] &= pairs.key < 0
        self._note_worst(at, pairs)
        for smallest, value in ((o.min_gap, pairs.gap), (o.min_ttc, pairs.ttc), (o.min_ttc2, pairs.ttc2)):
            smallest[at] = np.minimum(smallest[at], value)
        for largest, value in ((o.max_drac, pairs.drac), (o.max_required, pairs.required), (o.max_decel, braking)):
            largest[at] = np.maximum(largest[at], value)
        o.exposed[at] += time_below(pairs.ttc, EXPOSED, dt=t.dt)
        o.secondary[at] |= wrecked[slots].any(1)
        o.threat[at], o.seen[at] = pairs.threat, time
        crosses = o.key < 0
        if crosses.any():
            self._advance(time, at, pairs)

        over = ~t.here[o.slots].all(1) | (time - o.seen > _PAUSE)
        if crosses.any():
            left = o.leave.min(1)
            settled = np.isfinite(o.enter).all(1) | (time - left > _LONGEST_PET)
            over = ~t.here[o.slots].all(1) | np.where(np.isfinite(left), settled, time - o.seen > _PAUSE)
        self._close(over | np.where(crosses, wrecked[o.slots].all(1), wrecked[o.slots[:, 0]]))

    def close_all(self) -> None:
        """The run ends."""
        self._close(np.ones(len(self._open.key), np.bool_))

    def _rows_of(self, pairs: Pairs, time: float, equipped: Bools) -> Ints:
        """Where the pairs are among the open encounters; those that are not there yet begin."""
        at, known = find(pairs.key, self._open.key)
        if not known.all():
            t, fresh = self._traffic, take(pairs, ~known)
            at[~known] = len(self._open.key) + np.arange(len(fresh.key))
            where = np.column_stack([t.x[fresh.slots], t.y[fresh.slots]])[:, [0, 2, 1, 3]]
            self._open = joined(self._open, _Open.of(fresh, time, where, equipped[fresh.slots]))
        return at

    def _note_worst(self, at: Ints, pairs: Pairs) -> None:
        """Who, where, and in what error at the smallest TTC so far."""
        t, o = self._traffic, self._open
        worse = np.flatnonzero(pairs.ttc < o.min_ttc[at])
        rows, slots = at[worse], pairs.slots[worse]
        o.worst[rows] = pairs.second[worse]
        o.where[rows] = np.column_stack([t.x[slots], t.y[slots]])[:, [0, 2, 1, 3]]
        for k in worse[pairs.ttc[worse] < THREAT].tolist():
            one, other = pairs.slots[k].tolist()
            made = self._errors.setdefault(int(pairs.key[k]), ["", ""])
            made[:] = [self._error(one, other) or made[0], self._error(other, one) or made[1]]

    def _advance(self, time: float, at: Ints, pairs: Pairs) -> None:
        """Take all on to where the paths cross, also those that are no pair any more since one has left it."""
        t, o = self._traffic, self._open
        t.read(o.slots[t.here[o.slots]])
        pace = (t.speed[o.slots] + t.old_speed[o.slots]) / 2
        o.zone[:] -= np.repeat(pace * t.dt, 2, axis=1)
        o.zone[at] = pairs.zone
        for instants, beyond in ((o.enter, -o.zone[:, ::2]), (o.leave, -o.zone[:, 1::2] - t.length[o.slots])):
            now = (beyond >= 0) & np.isinf(instants)
            ago = np.divide(beyond, pace, out=np.zeros_like(pace), where=now & (pace > 0))
            instants[now] = time - np.minimum(ago[now], t.dt)

    def _close(self, over: Bools, *, crashed: bool = False) -> None:
        """End encounters; rows for those that came to matter."""
        if not over.any():
            return
        o = take(self._open, over)
        self._open = take(self._open, ~over)
        crosses = o.key < 0
        row, known = np.arange(len(o.key)), np.isfinite(o.enter).any(1)
        ego = np.where(crosses & known, np.argmax(o.enter, 1), o.worst)
        gap = pet(leave=o.leave[row, 1 - ego], enter=o.enter[row, ego])
        hardest = np.where(crosses, o.max_decel.max(1), o.max_decel[:, 0])
        near = hardest > self._evasive
        matters = near | np.where(crosses, (gap < _PET) | (o.min_ttc < EXPOSED), o.min_ttc < THREAT)
        t = self._traffic
        for k in range(len(o.key)):
            errors = self._errors.pop(int(o.key[k]), ["", ""])
            if not (matters[k] or crashed):
                continue
            e = int(ego[k])
            one, other = o.slots[k, e], o.slots[k, 1 - e]
            booked: dict[str, Any] = {
                "conflict_id": len(self.rows),
                "kind": "crossing" if crosses[k] else "following",
                "ego": t.ids[one],
                "other": t.ids[other],
                "ego_vclass": t.vclass[one],
                "other_vclass": t.vclass[other],
                "ego_equipped": bool(o.equipped[k, e]),
                "other_equipped": bool(o.equipped[k, 1 - e]),
                "begin_s": o.begin[k],
                "end_s": o.seen[k],
                "min_ttc_s": o.min_ttc[k],
                "min_ttc2_s": o.min_ttc2[k],
                "max_drac_mps2": o.max_drac[k],
                "max_required_decel_mps2": o.max_required[k],
                "min_gap_m": o.min_gap[k],
                "pet_s": float(gap[k]) if np.isfinite(gap[k]) and not crashed else None,
                "exposed_s": o.exposed[k],
                "max_decel_mps2": o.max_decel[k, e],
                "near_crash": bool(near[k] and not crashed),
                "crashed": crashed,
                "secondary": bool(o.secondary[k]),
                "ego_error": errors[e],
                "other_error": errors[1 - e],
                "x_m": o.where[k, 2 * e],
                "y_m": o.where[k, 2 * e + 1],
            }
            self.rows.append(booked)
            self.ended += [] if crashed else [booked]
