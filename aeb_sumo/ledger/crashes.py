"""Crashes: one row each, with what both did and carried, and what it did to them."""

from collections import deque
from collections.abc import Callable, Collection
from typing import Any

import numpy as np

from aeb_sumo.fleets import Fleets
from aeb_sumo.ledger.rows import Rows
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
        rows: in the order of time, once nothing more is to come of what SUMO's own check says of them.
        confirmed: how many of these it has reported.
    """

    def __init__(self, traffic: Traffic, fleet: Fleets, error: Callable[[int, int], str]) -> None:
        self._traffic, self._fleet, self._error = traffic, fleet, error
        self.rows = Rows("crashes")
        self.confirmed = 0
        self._count = 0
        self._fresh: deque[dict[str, Any]] = deque()  # of which the check may yet say something

    def __len__(self) -> int:
        return self._count

    def book(self, crash: Crash) -> None:
        """A crash has happened."""
        t, hit = self._traffic, crash.impact
        row = {
            "crash_id": self._count,
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
        self._fresh.append(row | risks(hit, crash.kind, t.vclass))
        self._count += 1

    def reconcile(self, reported: Collection[tuple[str, ...]], gone: Collection[str] | None = None) -> None:
        """Write down the crashes of which all is known: whether SUMO's own check has reported them.

        Args:
            reported: its pairs, in alphabetical order.
            gone: who has left the road and cannot be reported any more; None for everybody, at the end of the run.
        """
        for row in self._fresh:
            pair = tuple(sorted((row["striker"], row["struck"])))
            if gone is None or pair[0] in gone or pair[1] in gone:
                row.setdefault("sumo_reported", pair in reported)
        while self._fresh and "sumo_reported" in self._fresh[0]:
            row = self._fresh.popleft()
            self.confirmed += row["sumo_reported"]
            self.rows.append(row)
