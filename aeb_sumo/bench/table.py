"""From measurements to a line of the table."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from statistics import median
from typing import Any

from aeb_sumo.bench.measure import Measured

__all__ = ["Line", "Side", "Spread"]


@dataclass(frozen=True)
class Spread:
    """A figure measured several times: the one in the middle, the smallest and the largest."""

    median: float
    low: float
    high: float

    @classmethod
    def of(cls, values: Sequence[float]) -> "Spread":
        """Of one value or more."""
        return cls(median(values), min(values), max(values))


@dataclass(frozen=True)
class Side:
    """The measurements of one and the same.

    Attributes:
        measured: one or more.
        step_length: [s].
    """

    measured: tuple[Measured, ...]
    step_length: float

    @property
    def vehicles(self) -> float:
        """Present on average."""
        return median(m.vehicle_steps / m.steps for m in self.measured)

    @property
    def microseconds(self) -> Spread:
        """CPU time per vehicle and step [us]."""
        return Spread.of([1e6 * m.cpu / m.vehicle_steps for m in self.measured])

    @property
    def hours_per_hour(self) -> float:
        """Vehicle-hours that are simulated in an hour of one core."""
        return median(m.vehicle_steps * self.step_length / m.cpu for m in self.measured)

    @property
    def memory(self) -> float:
        """Largest resident size of any of the processes [MB]."""
        return max(m.memory for m in self.measured) / 1e6

    def record(self) -> dict[str, Any]:
        """For JSON, with units in the names."""
        return {
            "vehicles_present": self.vehicles,
            "us_per_vehicle_step": asdict(self.microseconds),
            "vehicle_hours_per_core_hour": self.hours_per_hour,
            "peak_memory_mb": self.memory,
            "measured": [
                {"cpu_s": m.cpu, "steps": m.steps, "vehicle_steps": m.vehicle_steps, "memory_bytes": m.memory}
                for m in self.measured
            ],
        }


@dataclass(frozen=True, kw_only=True)
class Line:
    """A fleet, a strategy and a step length: the same world stepped bare and equipped, in turn.

    Attributes:
        scenario: by name.
        asked: vehicles that were asked for; None for those that there are.
        strategy: of the cars.
        begin: simulated time from which on the worlds were stepped [s].
        sumo: version of SUMO.
        bare: the measurements of SUMO by itself.
        equipped: those of the run, one for each of these.
    """

    scenario: str
    asked: int | None
    strategy: str
    begin: float
    sumo: str
    bare: Side
    equipped: Side

    @property
    def ratio(self) -> Spread:
        """CPU time of a step, equipped over bare."""
        return self._ratio(lambda m: m.cpu / m.steps)

    @property
    def ratio_per_vehicle(self) -> Spread:
        """CPU time of a vehicle-step, equipped over bare; other than `ratio` where AEBs change how many are present."""
        return self._ratio(lambda m: m.cpu / m.vehicle_steps)

    def record(self) -> dict[str, Any]:
        """For JSON, with units in the names."""
        return {
            "scenario": self.scenario,
            "vehicles_asked": self.asked,
            "strategy": self.strategy,
            "step_length_s": self.bare.step_length,
            "begin_s": self.begin,
            "ratio": asdict(self.ratio),
            "ratio_per_vehicle_step": asdict(self.ratio_per_vehicle),
            "bare": self.bare.record(),
            "equipped": self.equipped.record(),
        }

    def _ratio(self, cost: Callable[[Measured], float]) -> Spread:
        pairs = zip(self.bare.measured, self.equipped.measured, strict=True)
        return Spread.of([cost(equipped) / cost(bare) for bare, equipped in pairs])
