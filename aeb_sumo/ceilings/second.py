"""The baseline once more, with a book of ceilings."""

from collections.abc import Callable
from typing import Any

import pandas as pd
import pyarrow as pa

from aeb_sumo.ceilings.book import Book
from aeb_sumo.ceilings.cases import cases
from aeb_sumo.equipment import Equipment, Share, System
from aeb_sumo.errors import InputError
from aeb_sumo.results import TABLES, Results
from aeb_sumo.scenarios import Scenario
from aeb_sumo.simulate import Progress, run
from aeb_sumo.world.fork import Forks

__all__ = ["CEILINGS", "ceilings"]

CEILINGS = ("perfect", "careful")
"""Strategies that are ceilings."""


def ceilings(
    scenario: Scenario,
    baseline: Results,
    *,
    beside: Equipment | None = None,
    forks: Forks | None = None,
    progress: Callable[[Progress], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> Results:
    """The tables of a baseline, with table `ceilings` filled in; all others are the same.

    Args:
        scenario: what was simulated, varied as it was then.
        baseline: one run of it without AEB.
        beside: AEBs that are put in the place of the ceilings as well, to compare; shares do not matter.
        forks: where the other worlds live; None for as many at a time as there are free cores.
        progress: called after every step of the second run, which ends with the last crash.
        stop: asked after every step; True ends it: what is not known then is unknown.

    Raises:
        InputError: it is not one run, not of this scenario, or not without AEB.
    """
    runs = baseline.runs
    if len(runs) != 1:
        raise InputError(f"ceilings are those of one run, not of {len(runs)}")
    of = runs.iloc[0]
    if of["strategy"] != "none":
        raise InputError(f"ceilings are those of a baseline, strategy none, not {of['strategy']}")
    if of["scenario"] != scenario.name:
        raise InputError(f"the baseline is one of scenario {of['scenario']}, not {scenario.name}")
    crashes = baseline.crashes
    rows: list[dict[str, Any]] = []
    if len(crashes):
        systems = {s.name: s for s in (*(beside.systems if beside else ()), *(System.of(name) for name in CEILINGS))}
        book = Book(
            list(cases(crashes, [*CEILINGS, *sorted(systems.keys() - CEILINGS)])), Forks() if forks is None else forks
        )
        step, begin = float(of["step_length_s"]), float(of["begin_s"])
        try:
            again = run(
                scenario,
                equip=Equipment(tuple(Share(system=system, share=0.0) for system in systems.values())),
                seed=int(of["seed"]),
                duration=float(crashes["time_s"].max()) + step - begin,
                step_length=step,
                blockage=float(of["blockage_s"]),
                trace=book,
                progress=progress,
                stop=stop,
            )
            rows = book.rows(_strayed(crashes, again))
        finally:
            book.forks.end("the second run is over")
    table = pa.Table.from_pylist([{"run_id": of["run_id"], **row} for row in rows], schema=TABLES["ceilings"].arrow())
    return Results(baseline.tables | {"ceilings": table})


def _strayed(crashes: pd.DataFrame, again: Results) -> str:
    """Why the second run says nothing of the first; empty if its crashes are the same."""
    outcome, reason = again.runs[["outcome", "reason"]].iloc[0]
    if outcome != "completed":
        return f"the second run {'was' if outcome == 'interrupted' else 'has'} {outcome} {reason}".rstrip()
    labels = ["run_id", "sumo_reported"]  # SUMO may report a crash later than it happens
    if not again.crashes.drop(columns=labels).equals(crashes.drop(columns=labels)):
        return "the second run had other crashes than the first"
    return ""
