"""Interventions: what an AEB did, from its first warning or braking until it has been doing neither for a while."""

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from aeb_sumo.fleets import PAUSE
from aeb_sumo.ledger.rows import Rows
from aeb_sumo.strategies.base import Phase

__all__ = ["Action", "Intervention", "Interventions"]


class Action(NamedTuple):
    """What one vehicle's AEB does in one step, and why.

    Attributes:
        strategy: its system's name.
        phase: demanded.
        decel: by the AEB's brake, >= 0 [m/s2].
        speed: own [m/s].
        target: id of the target, or empty; with its class, kind, gap [m], TTC and TTC2 [s], closing speed [m/s].
        error: what the driver does wrong, or empty.
        x, y: front bumper [m].
        lane: asked for the lane of the front where it is needed.
    """

    strategy: str
    phase: int
    decel: float
    speed: float
    target: str
    target_vclass: str
    target_kind: str
    gap: float
    ttc: float
    ttc2: float
    closing_speed: float
    error: str
    x: float
    y: float
    lane: Callable[[], str]


@dataclass
class Intervention:
    """One intervention, until it is a row.

    Attributes:
        row: what is known of it.
        last: when it last acted [s].
        lowest: own speed so far [m/s].
        braking_from: own speed at the first braking [m/s].
        open: it has not ended.
        judged: nothing more is to come of its verdict.
    """

    row: dict[str, Any]
    last: float
    lowest: float
    braking_from: float | None = None
    open: bool = True
    judged: bool = True

    @property
    def span(self) -> tuple[float, float]:
        """When it began, and when it last acted [s]."""
        return self.row["begin_s"], self.last

    def judge(self, verdict: Mapping[str, Any]) -> None:
        """Its verdict, as columns; none of them: there is none."""
        self.row |= verdict
        self.judged = True


@dataclass
class Interventions:
    """Book of interventions.

    Attributes:
        judged: verdicts are given, so that a row waits for its own.
        rows: those that have ended.
    """

    judged: bool = False
    rows: Rows = field(default_factory=lambda: Rows("interventions"))
    _open: dict[str, Intervention] = field(default_factory=dict)
    _waiting: deque[Intervention] = field(default_factory=deque)
    _ended: int = 0

    def __len__(self) -> int:
        """Those that have ended."""
        return self._ended

    def act(self, time: float, vehicle: str, vclass: str, action: Action) -> Intervention | None:
        """A vehicle's AEB warns or brakes in the step that begins at `time` [s]; the intervention, if one begins."""
        if vehicle in self._open and time - self._open[vehicle].last > PAUSE:
            self.close(vehicle, "released")
        entry, new = self._open.get(vehicle), None
        if entry is None:
            entry = new = self._open[vehicle] = self._begin(time, vehicle, vclass, action)
        row = entry.row
        entry.last = time
        entry.lowest = min(entry.lowest, action.speed)
        row["phase"] = max(row["phase"], action.phase)
        row["max_decel_mps2"] = max(row["max_decel_mps2"], action.decel)
        if action.target:
            row["min_gap_m"] = float(np.fmin(row["min_gap_m"], action.gap))
        if action.phase >= Phase.PARTIAL_BRAKE and entry.braking_from is None:
            entry.braking_from = entry.lowest = action.speed
            row |= {
                "brake_s": time,
                "trigger_gap_m": action.gap,
                "trigger_ttc_s": action.ttc,
                "trigger_ttc2_s": action.ttc2,
                "target": action.target,
                "target_vclass": action.target_vclass,
                "target_kind": action.target_kind,
            }
        if action.phase == Phase.FULL_BRAKE and row["full_brake_s"] is None:
            row["full_brake_s"] = time
        return new

    def _begin(self, time: float, vehicle: str, vclass: str, action: Action) -> Intervention:
        row = {
            "vehicle": vehicle,
            "vclass": vclass,
            "strategy": action.strategy,
            "phase": action.phase,
            "target": action.target,
            "target_vclass": action.target_vclass,
            "target_kind": action.target_kind,
            "begin_s": time,
            "brake_s": None,
            "full_brake_s": None,
            "warn_gap_m": action.gap,
            "warn_ttc_s": action.ttc,
            "warn_ttc2_s": action.ttc2,
            "trigger_gap_m": None,
            "trigger_ttc_s": None,
            "trigger_ttc2_s": None,
            "speed_mps": action.speed,
            "closing_speed_mps": action.closing_speed,
            "max_decel_mps2": 0.0,
            "min_gap_m": action.gap,
            "driver_error": action.error,
            "x_m": action.x,
            "y_m": action.y,
            "lane": action.lane(),
            "verdict": "",
            "verdict_reason": "",
            "acted_by": "",
        }
        return Intervention(row, time, action.speed, judged=not self.judged)

    def expire(self, time: float) -> None:
        """End those that have been quiet for `PAUSE`."""
        for vehicle in [v for v, entry in self._open.items() if time - entry.last > PAUSE]:
            self.close(vehicle, "released")

    def close(self, vehicle: str, why: str, speed: float = np.inf) -> None:
        """End a vehicle's intervention, if it has one, at a `speed` [m/s] that may be lower than any booked so far."""
        entry = self._open.pop(vehicle, None)
        if entry is None:
            return
        if why == "released" and entry.braking_from is not None and entry.lowest == 0:
            why = "standstill"
        row = entry.row
        entry.lowest = min(entry.lowest, speed)
        row["intervention_id"] = self._ended
        row["phase"] = Phase(row["phase"]).name.lower()
        row["end_s"] = entry.last
        row["ended_by"] = why
        row["speed_reduction_mps"] = 0.0 if entry.braking_from is None else entry.braking_from - entry.lowest
        entry.open = False
        self._ended += 1
        self._waiting.append(entry)
        self.flush()

    def close_all(self) -> None:
        """The run ends."""
        for vehicle in list(self._open):
            self.close(vehicle, "run_end")

    def flush(self) -> None:
        """Write down those that nothing more is to come of, in the order of their ends."""
        while self._waiting and self._waiting[0].judged:
            self.rows.append(self._waiting.popleft().row)
