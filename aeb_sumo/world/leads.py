"""The vehicle ahead of each vehicle: searched for in a cycle, and read in every step where a conflict is possible."""

from itertools import repeat

import libsumo
import numpy as np

from aeb_sumo.compiled import kernel
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

    An AEB at work takes the closing speed away long before it has done. So it watches whoever is ahead in every step,
    and so does one behind somebody who is known to brake hard; drivers and books do not know of this.

    Attributes:
        horizon: per slot, see above [s].
        lead, gap: per slot, slot of the vehicle ahead at the last search, -1 for none within 150 m, and its distance,
            bumper to bumper [m], `inf` for none. SUMO leaves the ego's minGap out of its answer; here it is back in. In
            and before junctions SUMO's gaps are not to be trusted (see `perception.lead.sees_lead`).
        rate: per slot, how fast the gap has shrunk between the last two searches, or does, if the lead is new [m/s];
            nan for none.
        egos: slots of those with whom a conflict is possible, rising; for them lead and gap are of this step.
        possible: per slot, whether it is one of them.
        at_work: per slot, whether an AEB there is.
        watched: per slot, an AEB there watches the one ahead: a conflict is possible, or see above.
        target, target_gap: per slot, whom, and its distance; as `lead` and `gap` where a conflict is possible.
        known: per slot, the search before had found the same lead.
    """

    def __init__(self, traffic: Traffic, *, cycle: float, horizon: float) -> None:
        """`cycle`: of the search [s], rounded to steps, at least one; `horizon` [s]: unless `watch` says otherwise."""
        self._traffic = traffic
        self._least = horizon
        self.horizon: Floats = np.zeros(0)
        self._every = max(1, round(cycle / traffic.dt))  # steps
        self._turn: list[dict[int, str]] = [{} for _ in range(self._every)]  # slot -> id, by phase
        self._rows: list[tuple[Ints, list[str]] | None] = [None] * self._every  # the same, as `_search` has it
        self.lead: Ints = np.zeros(0, np.int64)
        self.gap: Floats = np.zeros(0)
        self.egos: Ints = np.zeros(0, np.int64)
        self.possible: Bools = np.zeros(0, np.bool_)
        self.at_work: Bools = np.zeros(0, np.bool_)
        self.watched: Bools = np.zeros(0, np.bool_)
        self.target: Ints = np.zeros(0, np.int64)
        self.target_gap: Floats = np.zeros(0)
        self._watching: Bools = np.zeros(0, np.bool_)
        self.known: Bools = np.zeros(0, np.bool_)
        self.rate: Floats = np.zeros(0)
        # What the last search found, and in which step: the lead and its gap.
        self._found_at: Ints = np.zeros(0, np.int64)
        self._found: Ints = np.zeros(0, np.int64)
        self._found_gap: Floats = np.zeros(0)
        self._now: dict[int, tuple[int, float]] = {}

    def step(self, at_work: Ints, braking: Ints) -> None:
        """From the traffic just observed to `egos`, and their leads and gaps.

        Args:
            at_work: slots of those whose AEB was at work in the step that ended.
            braking: slots of those who braked hard in it, for all that is known without asking SUMO.
        """
        t = self._traffic
        self._now = {}
        if len(self.lead) < t.capacity:
            self._fit()
        if t.left or t.departed:
            self._enrol()
        phase = t.step % self._every
        turn = self._turn[phase]
        searching = self._rows[phase]
        if searching is None:
            searching = self._rows[phase] = np.fromiter(turn, np.int64, len(turn)), list(turn.values())
        known = self._watching.nonzero()[0]
        if len(known):
            self._look_again(known[t.here[known]], phase)
        if turn:
            self._search(*searching)
        new = [slot for slot in t.departed if slot not in turn]
        if new:  # who has just come does not wait for his turn
            self._search(np.array(new), [t.ids[slot] for slot in new])
        self.possible = self._watching & (self.lead >= 0) & t.here
        self.egos = self.possible.nonzero()[0]
        self.watched, self.target, self.target_gap = self.possible, self.lead, self.gap
        self.at_work = mask(at_work, t.capacity)
        if len(at_work) or len(braking):
            self._keep(np.append(at_work, self.behind(braking)))

    def _keep(self, slots: Ints) -> None:
        """These watch the one ahead, too."""
        self.watched, self.target, self.target_gap = self.watched.copy(), self.target.copy(), self.target_gap.copy()
        for slot in slots[self._traffic.here[slots] & ~self.possible[slots]].tolist():
            self.target[slot], self.target_gap[slot] = self.now(slot)
            self.watched[slot] = self.target[slot] >= 0

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
        if t.left:
            gone = np.array([slot for slot, _ in t.left])
            for slot in gone.tolist():
                for phase, turn in enumerate(self._turn):
                    if turn.pop(slot, None) is not None:
                        self._rows[phase] = None
            went = mask(gone, t.capacity)
            of_gone = went | (went[self.lead] & (self.lead >= 0)) | (went[self._found] & (self._found >= 0))
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
        t, get, n = self._traffic, libsumo.vehicle.getLeader, len(rows)
        names, gaps = zip(*[get(vehicle, REACH) or _NOBODY for vehicle in ids], strict=True)
        lead = np.fromiter(map(t.slot.get, names, repeat(-1)), np.int64, n)
        closing = np.zeros(n)  # needed where it is another than before
        speed = libsumo.vehicle.getSpeed
        for k in ((lead != self._found[rows]) & (lead >= 0)).nonzero()[0].tolist():
            closing[k] = speed(ids[k]) - speed(names[k])
        _judge(
            rows, lead, np.fromiter(gaps, float, n), closing, t.min_gap, self.horizon, t.step, t.dt, self._found,
            self._found_at, self._found_gap, self.rate, self.known, self._watching, self.lead, self.gap,
        )  # fmt: skip


@kernel
def _judge(
    rows: Ints, ahead: Ints, distance: Floats, closing: Floats, min_gap: Floats, horizon: Floats, step: int, dt: float,
    found: Ints, found_at: Ints, found_gap: Floats, rate: Floats, known: Bools, watching: Bools,
    lead: Ints, gap: Floats,
) -> None:  # fmt: skip
    """Per slot, what is known now that each of these rows has found who is ahead, how far and closing in how fast."""
    for k in range(len(rows)):
        row = rows[k]
        known[row] = watching[row] = False
        new_gap, new_rate = np.inf, np.nan
        if ahead[k] >= 0:
            new_gap, new_rate, growth = distance[k] + min_gap[row], closing[k], 0.0
            if ahead[k] == found[row]:
                known[row] = True
                span = (step - found_at[row]) * dt
                new_rate = (found_gap[row] - new_gap) / span
                growth = (new_rate - rate[row]) / span
            sooner = horizon[row] - _SOONER
            growing = new_rate * sooner + np.maximum(growth, 0.0) * (sooner * sooner / 2)
            near = new_gap < CLOSE + np.maximum(new_rate * horizon[row], growing)
            watching[row] = near and (new_rate != 0 or growth != 0)
        found_at[row] = step
        lead[row] = found[row] = ahead[k]
        gap[row] = found_gap[row] = new_gap
        rate[row] = new_rate
