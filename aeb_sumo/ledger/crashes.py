"""Crashes: one row each, with what both did and carried, and what it did to them."""

from collections.abc import Callable, Collection
from typing import Any

import numpy as np

from aeb_sumo.fleets import Fleets
from aeb_sumo.ledger.severity import risks
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.wrecks import Crash

__all__ = ["Crashes"]


class Crashes:
    """Book of crashes.

    Args:
        traffic: all road users.
        fleet: their AEBs.
        error: names the error that the driver in one slot makes towards that in another, or is empty.

    Attributes:
        rows: in the order of time, all but what SUMO's own check said of them.
    """

    def __init__(self, traffic: Traffic, fleet: Fleets, error: Callable[[int, int], str]) -> None:
        self._traffic, self._fleet, self._error = traffic, fleet, error
        self.rows: list[dict[str, Any]] = []

    def book(self, crash: Crash) -> None:
        """A crash has happened."""
        t, hit = self._traffic, crash.impact
        row = {
            "crash_id": len(self.rows),
            "time_s": hit.time,
            "kind": crash.kind,
            "typology": crash.typology,
            "x_m": hit.x,
            "y_m": hit.y,
            "lane": crash.lane,
            "impact_speed_mps": hit.impact_speed,
            "angle_deg": float(np.degrees(hit.angle)),
            "secondary": crash.secondary,
            "striker": crash.striker,
            "struck": crash.struck,
            "striker_speed_mps": hit.striker_speed,
            "struck_speed_mps": hit.struck_speed,
            "striker_delta_v_mps": hit.striker_delta_v,
            "struck_delta_v_mps": hit.struck_delta_v,
            "striker_aeb_phase": int(self._fleet.demand.phase[hit.striker]),
        }
        for who, slot, other in (("striker", hit.striker, hit.struck), ("struck", hit.struck, hit.striker)):
            row |= {
                f"{who}_vclass": t.vclass[slot],
                f"{who}_vtype": t.vtype[slot],
                f"{who}_equipped": bool(self._fleet.equipped[slot]),
                f"{who}_strategy": self._fleet.system(slot),
                f"{who}_error": self._error(slot, other),
            }
        self.rows.append(row | risks(hit, crash.kind, t.vclass))

    def reconcile(self, reported: Collection[tuple[str, ...]]) -> int:
        """Mark the crashes whose pair, in alphabetical order, SUMO's own collision check reported; returns how many."""
        for row in self.rows:
            row["sumo_reported"] = tuple(sorted((row["striker"], row["struck"]))) in reported
        return sum(row["sumo_reported"] for row in self.rows)
