"""Recorders: look on while a run is simulated. Traces: vehicles recorded step by step, for test cases and figures."""

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from aeb_sumo.engine import Engine

if TYPE_CHECKING:  # most runs are without a trace, and it takes long to import
    import pandas as pd

__all__ = ["Recorder", "Trace"]


class Recorder(Protocol):
    """Looks on; give it to `aeb_sumo.simulate.run`."""

    def attend(self, world: Engine) -> None:
        """A run begins."""

    def step(self, time: float) -> None:
        """A step has ended at `time` [s], and what all do in the coming one is decided, but not yet done."""


class Trace:
    """Records vehicles in every step of a run; give it to `aeb_sumo.simulate.run`.

    Args:
        vehicles: ids to record; none of them: all vehicles.

    Attributes:
        latest: the rows of the last step, by vehicle.
    """

    def __init__(self, *vehicles: str) -> None:
        self._vehicles = vehicles
        self._rows: list[dict[str, Any]] = []
        self.latest: dict[str, dict[str, Any]] = {}
        self._world: Engine

    def attend(self, world: Engine) -> None:
        """Record this run."""
        self._world = world
        self._rows, self.latest = [], {}

    def step(self, time: float) -> None:
        """Record the state at `time` [s] and what the AEBs demand for the coming step."""
        t, fleet = self._world.traffic, self._world.fleet
        wanted = [t.slot[v] for v in self._vehicles if v in t.slot] if self._vehicles else t.present.tolist()
        slots = np.array([s for s in wanted if t.here[s]], np.int64)
        t.read(slots)
        mu, known, target = self._world.friction.at(slots), fleet.friction_known(slots), fleet.targets(slots)
        self.latest = {}
        for k, slot in enumerate(slots.tolist()):
            aimed = int(target.slot[k])
            row = self.latest[t.ids[slot]] = {
                "time_s": time,
                "vehicle": t.ids[slot],
                "x_m": t.x[slot],
                "y_m": t.y[slot],
                "heading_rad": t.heading[slot],
                "length_m": t.length[slot],
                "width_m": t.width[slot],
                "speed_mps": t.speed[slot],
                "accel_mps2": t.accel[slot],
                "target": t.ids[aimed] if aimed >= 0 else "",
                "gap_m": target.gap[k],
                "closing_mps": target.closing_ahead[k],
                "phase": int(fleet.demand.phase[slot]),
                "demand_mps2": fleet.demand.decel[slot],
                "decel_mps2": fleet.decel[slot],
                "mu": mu[k],
                "mu_known": known[k],
            }
            self._rows.append(row)

    def frame(self) -> "pd.DataFrame":
        """One row per recorded vehicle and step.

        `accel_mps2` is that of the step before, `decel_mps2` the brake's in the step to come; `gap_m` (infinite without
        a target) and `closing_mps` are as the vehicle knows them; `phase` is a `Phase`.
        """
        import pandas as pd  # noqa: PLC0415

        return pd.DataFrame(self._rows)
