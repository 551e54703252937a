"""What the platform costs on top of SUMO: the same world stepped bare and with every car equipped, in turn."""

import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from math import ceil
from pathlib import Path

from aeb_sumo.bench.copies import side_by_side
from aeb_sumo.bench.machine import load, machine
from aeb_sumo.bench.measure import Measured, Stretch, measure_bare, measure_equipped, warm
from aeb_sumo.bench.process import in_fresh_processes, link
from aeb_sumo.bench.table import Line, Side, Spread
from aeb_sumo.errors import InputError
from aeb_sumo.scenarios import Scenario

__all__ = ["COPIED", "LARGEST", "Line", "Measured", "Plan", "Side", "Spread", "bench", "load", "machine"]

COPIED = "highway"
"""The scenario of which there are as many copies as a fleet needs."""

LARGEST = 100_000
"""Vehicles at most."""

PER_COPY = 250
"""Vehicles on one copy at most."""

# Measured on eight copies: 100 vehicles each at demand 0.5, where nobody queues; 242 after 300 s and 246 after 350 s at
# 1.1; 258 after 300 s, and then more and more, at 1.2.
_FREE_FLOW = 200.0  # vehicles on the road per unit of demand
_DEMAND = 1.1  # at most: the lane drop lets no more through, and the queue before it makes up the rest
_FULL = 300.0  # s until the road is full to its end
_PATIENCE = 1800.0  # s, our assumption


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What is measured.

    Attributes:
        scenario: what is simulated.
        vehicles: sizes of the fleet, for `COPIED`; (None,) for what is present at `begin`.
        strategies: names.
        step_lengths: [s]; None for the scenario's.
        steps: that are timed.
        repeat: how often each is measured.
        begin: simulated time since the scenario's begin from which on worlds are measured, if it says no vehicles [s].
    """

    scenario: Scenario
    vehicles: Sequence[int | None] = (None,)
    strategies: Sequence[str] = ("zhao2025",)
    step_lengths: Sequence[float | None] = (None,)
    steps: int = 300
    repeat: int = 3
    begin: float = 300.0

    @property
    def parts(self) -> int:
        """How often `bench` says that something is done."""
        return len(self.vehicles) * len(self.step_lengths) * (1 + self.repeat * len(self.strategies))


def bench(plan: Plan, done: Callable[[], None] = lambda: None) -> Iterator[Line]:
    """Measure, line by line.

    Args:
        plan: what.
        done: called after every world that is warm and every measurement.

    Yields:
        A line of the table.

    Raises:
        InputError: SUMO refuses the scenario, or as many vehicles are never present.
    """
    for vehicles in plan.vehicles:
        for step_length in plan.step_lengths:
            with tempfile.TemporaryDirectory(prefix="aeb-sumo-bench-") as name:
                folder = Path(name)
                stretch = _warmed(plan, folder, vehicles, step_length)
                done()
                for strategy in plan.strategies:
                    pairs = []
                    for _ in range(plan.repeat):
                        pairs.append(_pair(folder, stretch, strategy))
                        done()
                    bare, equipped = zip(*pairs, strict=True)
                    yield Line(
                        scenario=plan.scenario.name,
                        asked=vehicles,
                        strategy=strategy,
                        begin=stretch.begin,
                        sumo=stretch.sumo,
                        bare=Side(bare, stretch.step_length),
                        equipped=Side(equipped, stretch.step_length),
                    )


def _pair(folder: Path, stretch: Stretch, strategy: str) -> list[Measured]:
    """Bare and equipped, in two processes that take turns."""
    links = one, other = link()
    tasks = [partial(measure_bare, stretch, one), partial(measure_equipped, stretch, strategy, other)]
    pair = in_fresh_processes(folder, tasks, links)
    if not all(measured.vehicle_steps for measured in pair):
        raise InputError(
            f"no vehicle is present in {stretch.scenario.name} while it is measured; choose another --from"
        )
    return pair


def _warmed(plan: Plan, folder: Path, vehicles: int | None, step_length: float | None) -> Stretch:
    scenario, limit, at = plan.scenario, None, plan.begin
    if vehicles is not None:
        copies = ceil(vehicles / PER_COPY)
        demand = min(_DEMAND, vehicles / copies / _FREE_FLOW)
        scenario = side_by_side(scenario, copies, folder).varied(demand=demand)
        at, limit = _FULL, _PATIENCE
    warming = partial(
        warm, scenario, folder / "world.xml",
        step_length=step_length, steps=plan.steps, at=at, vehicles=vehicles, limit=limit,
    )  # fmt: skip
    (stretch,) = in_fresh_processes(folder, [warming])
    return stretch
