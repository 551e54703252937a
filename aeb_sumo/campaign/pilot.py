"""Short runs that tell what long ones will take."""

import json
import tempfile
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Any

import pandas as pd

from aeb_sumo.campaign.execute import Outcome, execute
from aeb_sumo.campaign.expansion import Job
from aeb_sumo.campaign.runner import execute_all
from aeb_sumo.errors import InputError
from aeb_sumo.results import Results, read

__all__ = ["PARTS", "Pilot", "alike", "by_group", "pilots"]

PARTS = 4
"""Of a pilot run: traffic builds up, and the last part stands for what comes after it; our assumption."""


@dataclass(frozen=True, kw_only=True)
class Pilot:
    """A short run.

    Attributes:
        seconds: simulated.
        outcome: what it took.
        results: its tables.
    """

    seconds: float
    outcome: Outcome
    results: Results

    def vehicle_seconds(self, span: float) -> float:
        """Time on the road of all vehicles, in a run of this many seconds."""
        return self._of("time_s", span)

    def km(self, span: float) -> float:
        """Vehicle-km in a run of this many seconds."""
        return self._of("distance_m", span) / 1000

    def cpu_s(self, span: float) -> float:
        """Processor time of a run of this many seconds: as much per vehicle and second as in this one."""
        seen = self.vehicle_seconds(self.seconds)
        growth = self.vehicle_seconds(span) / seen if seen else span / self.seconds
        return self.outcome.start_s + (self.outcome.cpu_s - self.outcome.start_s) * growth

    def _of(self, column: str, span: float) -> float:
        """A sum over the traffic: what was seen, and the last part again and again."""
        traffic: pd.DataFrame = self.results.frame("traffic")
        part = self.seconds / PARTS
        late = float(self.results.frame("runs")["begin_s"].iloc[0]) + self.seconds - 1.5 * part
        last = traffic.loc[traffic["begin_s"] > late, column].sum()
        return float(traffic[column].sum() + last * (span - self.seconds) / part)


def by_group(jobs: Iterable[Job]) -> dict[str, list[Job]]:
    """Jobs that differ in seed alone, by what they have in common."""
    groups: dict[str, list[Job]] = {}
    for job in jobs:
        groups.setdefault(_common(job.content, {"seed"}), []).append(job)
    return groups


def alike(content: object) -> str:
    """What runs have in common that tell of each other: all but seed, duration and version of the program."""
    return _common(content, {"seed", "duration_s", "interval_s", "code"})


def _common(content: object, without: set[str]) -> str:
    return json.dumps({k: v for k, v in dict(content).items() if k not in without}, sort_keys=True)  # type: ignore[call-overload]


def pilots(
    jobs: Sequence[Job], seconds: float, executor: Executor, done: Callable[[Outcome], None] = lambda _: None
) -> list[Pilot]:
    """A short run of each of some jobs.

    Args:
        jobs: what they are of.
        seconds: to simulate; less where the run itself is shorter.
        executor: as for a campaign.
        done: called after every run.

    Returns:
        In the order of `jobs`.

    Raises:
        InputError: one of them failed, as the run itself would.
    """
    spans = [seconds if job.span is None else min(seconds, job.span) for job in jobs]
    short = [job.changed(duration_s=s, interval_s=s / PARTS) for job, s in zip(jobs, spans, strict=True)]
    with tempfile.TemporaryDirectory(prefix="aeb-sumo-plan-") as folder:
        outcomes = {each.run_id: each for each in execute_all(short, folder, executor, how=_rehearsed, done=done)}
        for outcome in outcomes.values():
            if outcome.outcome != "completed":
                raise InputError(f"the pilot run {outcome.run_id} failed: {outcome.reason}")
        tables = read(folder)
    parts = {run: tables_of(tables, run) for run in outcomes}
    return [
        Pilot(seconds=s, outcome=outcomes[job.run_id], results=parts[job.run_id])
        for job, s in zip(short, spans, strict=True)
    ]


def _rehearsed(job: dict[str, Any]) -> Outcome:
    """A run for the second time: its worker then has at hand what it has in most runs of a campaign."""
    execute({**job, "out": f"{job['out']}/rehearsal"})
    return execute(job)


def tables_of(results: Results, run_id: str) -> Results:
    """The tables of one run."""
    import pyarrow.compute as pc  # noqa: PLC0415

    return Results({name: t.filter(pc.equal(t["run_id"], run_id)) for name, t in results.tables.items()})
