"""The vehicle ahead of each vehicle: searched for in a cycle, and read in every step where a conflict is possible."""

import libsumo
import numpy as np

from aeb_sumo.soa import Bools, Floats, Ints, fitted, mask
from aeb_sumo.world.observe import Traffic

__all__ = ["CLOSE", "REACH", "Leads"]

REACH = 150.0
"""How far ahead a lead is looked for [m]: as far as any sensor sees."""
CLOSE = 2.0
"""Nearer than this a conflict is always possible, unless both stand [m], our assumption."""

_SOONER = 1.0  # s, how much sooner than at the rate of now two have to touch if that goes on growing, our assumption
_NOBODY = ("", np.inf)


class Leads:
    """Who is ahead of whom, as SUMO names it.

    Every vehicle looks for the one ahead once per search cycle, at a phase of its own. From what it finds, and found
    the two times before, it knows the gap, how fast that shrinks, and whether faster and faster. If both would touch
    within the horizon going on at the same rate, or 1 s earlier at a rate that goes on growing, or are nearer than 2 m
    and move, a conflict is possible, and the gap is read in every step until the next search says otherwise. When SUMO
    names another in between, there is nobody until that search.

    Attributes:
        horizon: per slot, see above [s].
        lead, gap: per slot, slot of the vehicle ahead at the last search, -1 for none within 150 m, and its distance,
            bumper to bumper [m], `inf` for none. SUMO leaves the ego's minGap out of its answer; here it is back in. In
            and before junctions SUMO's gaps are not to be trusted (see `perception.lead.sees_lead`).
        rate: per slot, how fast the gap has shrunk between the last two searches, or does, if the lead is new [m/s];
            nan for none.
        egos: slots of those with whom a conflict is possible, rising; for them lead and gap are of this step.
        possible: per slot, whether it is one of them.
        known: per slot, the search before had found the same lead.
    """

    def __init__(self, traffic: Traffic, *, cycle: float, horizon: float) -> None:
        """`cycle`: of the search [s], rounded to steps, at least one; `horizon` [s]: unless `watch` says otherwise."""
        self._traffic = traffic
        self._least = horizon
        self.horizon: Floats = np.zeros(0)
        self._every = max(1, round(cycle / traffic.dt))  # steps
        self._turn: list[dict[int, str]] = [{} for _ in range(self._every)]  # slot -> id, by phase
        self._rows: list[Ints | None] = [None] * self._every  # their slots
        self.lead: Ints = np.zeros(0, np.int64)
        self.gap: Floats = np.zeros(0)
        self.egos: Ints = np.zeros(0, np.int64)
        self.possible: Bools = np.zeros(0, np.bool_)
        self._watching: Bools = np.zeros(0, np.bool_)
        self.known: Bools = np.zeros(0, np.bool_)
        self.rate: Floats = np.zeros(0)
        # What the last search found, and in which step: the lead and its gap.
        self._found_at: Ints = np.zeros(0, np.int64)
        self._found: Ints = np.zeros(0, np.int64)
        self._found_gap: Floats = np.zeros(0)
        self._now: dict[int, tuple[int, float]] = {}

    def step(self) -> None:
        """From the traffic just observed to `egos`, and their leads and gaps."""
        t = self._traffic
        self._now = {}
        if len(self.lead) < t.capacity:
            self._fit()
        if t.left or t.departed:
            self._enrol()
        phase = t.step % self._every
        rows = self._rows[phase]
        if rows is None:
            rows = self._rows[phase] = np.fromiter(self._turn[phase], np.int64, len(self._turn[phase]))
        known = self._watching.nonzero()[0]
        if len(known):
            self._look_again(known[t.here[known]], phase)
        if len(rows):
            self._search(rows, list(self._turn[phase].values()))
        new = [slot for slot in t.departed if slot not in self._turn[phase]]
        if new:  # who has just come does not wait for his turn
            self._search(np.array(new), [t.ids[slot] for slot in new])
        self.possible = self._watching & (self.lead >= 0) & t.here
        self.egos = self.possible.nonzero()[0]

    def now(self, slot: int) -> tuple[int, float]:
        """Lead and gap of a vehicle in this step, as `lead` and `gap` have them; not a matter of searching."""
        if slot not in self._now:
            t = self._traffic
            answer = libsumo.vehicle.getLeader(t.ids[slot], REACH)
            lead = -1 if answer is None else t.slot.get(answer[0], -1)
            self._now[slot] = (lead, answer[1] + float(t.min_gap[slot])) if lead >= 0 else (-1, np.inf)
        return self._now[slot]

    def watch(self, slot: int, horizon: float) -> None:
        """The vehicle in a slot, which has just come or got another system, has this horizon [s]."""
        if len(self.lead) < self._traffic.capacity:
            self._fit()
        self.horizon[slot] = horizon

    def behind(self, slots: Ints) -> Ints:
        """Slots of those whose last search has found one of these ahead."""
        t = self._traffic
        return (mask(slots, t.capacity)[self.lead] & (self.lead >= 0) & t.here).nonzero()[0]

    def _enrol(self) -> None:
        """Who came takes his turn from now on; nobody is behind or ahead any more of who went."""
        t = self._traffic
        gone = [slot for slot, _ in t.left]
        for slot in gone:
            for phase, turn in enumerate(self._turn):
                if turn.pop(slot, None) is not None:
                    self._rows[phase] = None
        if gone:
            of_gone = np.isin(self.lead, gone) | np.isin(self._found, gone)
            of_gone[gone] = True
            self._forget(of_gone.nonzero()[0])
        for slot in t.departed:
            phase = int(t.serial[slot]) % self._every
            self._turn[phase][slot] = t.ids[slot]
            self._rows[phase] = None
        if t.departed:
            self._forget(np.array(t.departed))

    def _fit(self) -> None:
        old, size = len(self.lead), self._traffic.capacity
        for name in ("lead", "gap", "_found", "_found_at", "_found_gap", "rate", "known", "_watching", "horizon"):
            setattr(self, name, fitted(getattr(self, name), size))
        self._forget(np.arange(old, size))
        self.horizon[old:] = self._least

    def _forget(self, rows: Ints) -> None:
        self.lead[rows] = self._found[rows] = -1
        self.gap[rows], self.rate[rows], self._watching[rows], self.known[rows] = np.inf, np.nan, False, False

    def _look_again(self, rows: Ints, phase: int) -> None:
        """Read the known leads of those who do not search in this step."""
        turn = self._turn[phase]
        for slot in rows.tolist():
            if slot not in turn and self.lead[slot] >= 0:
                lead, gap = self.now(slot)
                if lead == self.lead[slot]:
                    self.gap[slot] = gap
                else:
                    self.lead[slot], self.gap[slot] = -1, np.inf

    def _search(self, rows: Ints, ids: list[str]) -> None:
        """Who is ahead of these, and whether a conflict with him is possible."""
        t, get, slots = self._traffic, libsumo.vehicle.getLeader, self._traffic.slot
        answers = [get(vehicle, REACH) or _NOBODY for vehicle in ids]
        names, gaps = zip(*answers, strict=True)
        lead = np.array([slots.get(name, -1) for name in names])
        gap = np.where(lead >= 0, np.array(gaps) + t.min_gap[rows], np.inf)
        found = lead >= 0
        same = found & (lead == self._found[rows])
        span = np.where(same, (t.step - self._found_at[rows]) * t.dt, np.inf)
        rate = np.full(len(rows), np.nan)
        rate[same] = (self._found_gap[rows[same]] - gap[same]) / span[same]
        speed = libsumo.vehicle.getSpeed
        for k in (found & ~same).nonzero()[0].tolist():
            rate[k] = speed(ids[k]) - speed(names[k])
        growth = np.where(same, (rate - self.rate[rows]) / span, 0.0)
        horizon = self.horizon[rows]
        sooner = horizon - _SOONER
        growing = rate * sooner + np.maximum(growth, 0.0) * (sooner**2 / 2)
        near = gap < CLOSE + np.maximum(rate * horizon, growing)
        self._watching[rows] = near & ((rate != 0) | (growth != 0))
        self._found_at[rows], self.known[rows] = t.step, same
        self.lead[rows] = self._found[rows] = lead
        self.gap[rows] = self._found_gap[rows] = gap
        self.rate[rows] = rate
