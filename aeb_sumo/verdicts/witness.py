"""Looks on what happens to one vehicle, and to those behind it, in whichever world it is."""

from collections.abc import Sequence

import numpy as np

from aeb_sumo.engine import Engine
from aeb_sumo.ledger.conflicts import Conflicts
from aeb_sumo.ledger.severity import risks
from aeb_sumo.verdicts.judge import Hit, Outcome
from aeb_sumo.world.wrecks import Crash, pair_of

__all__ = ["Witness", "hit_of"]

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
        # Nor does a brake that an AEB applies show that there was danger: it is the drivers' that counts.
        for slots, hard in zip(pairs.slots[own].tolist(), self._conflicts.hard[own].tolist(), strict=True):
            self._near |= any(h and s not in self._engine.motorists.braked for s, h in zip(slots, hard, strict=True))
        self._gap = min(self._gap, float(pairs.gap[own].min(initial=np.inf)))
        # What stops a wreck is not its brake.
        behind = np.flatnonzero((leads.lead == slot) & t.here & ~self._engine.wrecks.wrecked)
        t.read(behind)
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
        pair = {crash.striker, crash.struck}
        own = self.vehicle in pair
        if own or self._behind & pair:
            self._hits.append(hit_of(crash, self._engine.traffic.vclass, own=own))

    def _followers(self) -> frozenset[str]:
        """Ids of the next few vehicles behind, one behind the other."""
        t, leads = self._engine.traffic, self._engine.leads
        chain, front = [], self._slot
        for _ in range(_BEHIND):
            behind = np.flatnonzero((leads.lead == front) & t.here)
            if not len(behind):
                break
            front = int(behind[np.argmin(leads.gap[behind])])
            chain.append(t.ids[front])
        return frozenset(chain)


def hit_of(crash: Crash, vclass: Sequence[str], *, own: bool) -> Hit:
    """A crash as verdicts have it.

    Args:
        crash: what happened.
        vclass: per slot, SUMO's vehicle class.
        own: see `Hit`.
    """
    hit, risk = crash.impact, risks(crash.impact, crash.kind, vclass)
    serious = [r for name, r in risk.items() if name.endswith("serious_risk") and r is not None]
    return Hit(
        pair=pair_of(crash.striker, crash.struck),
        own=own,
        impact_speed=hit.impact_speed,
        delta_v=max(hit.striker_delta_v, hit.struck_delta_v),
        serious_risk=sum(serious) if serious else None,
    )
