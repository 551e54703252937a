"""Looks on what happens to one vehicle, and to those behind it, in whichever world it is."""

import numpy as np

from aeb_sumo.engine import Engine
from aeb_sumo.ledger.conflicts import Conflicts
from aeb_sumo.ledger.severity import risks
from aeb_sumo.verdicts.judge import Hit, Outcome
from aeb_sumo.world.wrecks import Crash

__all__ = ["Witness"]

_BEHIND = 3  # vehicles behind whose crashes count, our assumption
_CLOSE = 3.0  # s of headway within which somebody follows, our assumption


class Witness:
    """Follows the vehicle in a slot from now on; call `step` when the books of a step are written.

    Attributes:
        vehicle: its id.
    """

    def __init__(self, engine: Engine, conflicts: Conflicts, slot: int) -> None:
        self._engine, self._conflicts, self._slot = engine, conflicts, slot
        self._serial = engine.traffic.serial[slot]
        self.vehicle = engine.traffic.ids[slot]
        self._behind = self._followers()
        self._hits: list[Hit] = []
        self._near = False
        self._gap = self._pet = np.inf
        self._follower = 0.0

    @property
    def slot(self) -> int | None:
        """Of the vehicle; None when it is not on the road."""
        t = self._engine.traffic
        return self._slot if t.here[self._slot] and t.serial[self._slot] == self._serial else None

    def step(self) -> None:
        """See what has happened in the last step."""
        for crash in self._engine.crashes:
            self._see(crash)
        for row in self._conflicts.ended:
            if self.vehicle in (row["ego"], row["other"]) and row["pet_s"] is not None:
                self._pet = min(self._pet, row["pet_s"])
        slot = self.slot
        if slot is None:
            return
        t, leads, pairs = self._engine.traffic, self._engine.leads, self._conflicts.pairs
        # An encounter with somebody behind is not the vehicle's to mend.
        own = (pairs.slots[:, 0] == slot) | ((pairs.slots[:, 1] == slot) & (pairs.key < 0))
        self._near |= bool(self._conflicts.hard[own].any())
        self._gap = min(self._gap, float(pairs.gap[own].min(initial=np.inf)))
        # What stops a wreck is not its brake.
        behind = np.flatnonzero((leads.lead == slot) & t.here & ~self._engine.wrecks.wrecked)
        close = behind[leads.gap[behind] <= _CLOSE * t.speed[behind]]
        self._follower = max(self._follower, float((-t.accel[close]).max(initial=0.0)))

    def outcome(self) -> Outcome:
        """What has been seen so far."""
        return Outcome(
            hits=tuple(self._hits),
            near_crash=self._near,
            min_gap=0.0 if any(hit.own for hit in self._hits) else self._gap,
            pet=self._pet,
            follower_decel=self._follower,
        )

    def _see(self, crash: Crash) -> None:
        one, other = sorted((crash.striker, crash.struck))
        own = self.vehicle in (one, other)
        if not own and not self._behind & {one, other}:
            return
        hit = crash.impact
        known = risks(hit, crash.kind, self._engine.traffic.vclass)
        risk = [r for name, r in known.items() if name.endswith("serious_risk") and r is not None]
        self._hits.append(
            Hit(
                pair=(one, other),
                own=own,
                impact_speed=hit.impact_speed,
                delta_v=max(hit.striker_delta_v, hit.struck_delta_v),
                serious_risk=sum(risk) if risk else None,
            )
        )

    def _followers(self) -> frozenset[str]:
        """Ids of the next few vehicles behind."""
        t, lead = self._engine.traffic, self._engine.leads.lead
        chain: list[int] = []
        front = np.array([self._slot])
        for _ in range(_BEHIND):
            front = np.flatnonzero(np.isin(lead, front) & t.here)
            chain += front.tolist()
        return frozenset(t.ids[slot] for slot in chain)
