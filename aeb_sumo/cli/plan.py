"""`aeb-sumo plan`."""

from collections.abc import Collection, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from math import isnan, nan
from pathlib import Path

import click
import numpy as np
import pandas as pd
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

import analysis
from aeb_sumo.campaign import journal, manifest
from aeb_sumo.campaign.expansion import Job, expand
from aeb_sumo.campaign.pilot import Pilot, alike, by_group, pilots
from aeb_sumo.campaign.spec import read
from aeb_sumo.cli.campaign import cores, interruptible
from aeb_sumo.cli.show import console
from aeb_sumo.errors import InputError
from aeb_sumo.results import finished
from analysis.forecast import difference_half_width, forecast

__all__ = ["plan"]

_MILLION = 1e6  # km that rates are of
_FEW = 10  # crashes, below which a note says how little is known, our assumption


@dataclass(frozen=True, kw_only=True)
class _Group:
    """Runs that differ in seed alone.

    Attributes:
        jobs: planned.
        left: of these, those that are not there yet.
        figures: `crashes` and `km` that are known, by seed.
        km: of one run.
        cpu_s: that one run takes.
        runs: that this is known from; 0 for a pilot.
        shorter: these do not last as long as the ones that are planned.
    """

    jobs: Sequence[Job]
    left: int
    figures: pd.DataFrame
    km: float
    cpu_s: float
    runs: int
    shorter: bool = False


@click.command()
@click.argument("spec", type=click.Path(path_type=Path))
@click.option("--have", help="Folder of a campaign with such runs, the same or at other seeds, instead of pilot runs.")
@click.option("--pilot", type=float, default=180.0, show_default=True, help="Simulated seconds of a pilot run.")
@click.option("--workers", type=click.IntRange(1), help="Runs at a time. [default: one per core]")
@click.option("--quiet", is_flag=True, help="No progress bar.")
def plan(spec: Path, have: str | None, pilot: float, workers: int | None, quiet: bool) -> int:
    """Say what the campaign SPEC will cost, and how much it will tell, before it is started."""
    if not 0 < pilot < np.inf:
        raise InputError(f"--pilot must be a positive number of seconds, not {pilot:g}")
    jobs = by_group(expand(read(spec)))
    known = {} if have is None else _known(have)
    there = set() if have is None else finished(have)
    unknown = [some[0] for some in jobs.values() if alike(some[0].content) not in known]
    workers = workers or cores()
    found = iter(_pilots(unknown, pilot, workers, quiet=quiet))
    groups = [
        _from_runs(some, known[alike(some[0].content)], there) if alike(some[0].content) in known
        else _from_pilot(some, next(found))
        for some in jobs.values()
    ]  # fmt: skip
    _print(groups, spec.name)
    _print_cost(groups, workers)
    _print_basis(groups, pilot)
    return 0


def _known(have: str) -> dict[str, pd.DataFrame]:
    """What runs of a folder tell: `crashes`, `km`, `hours`, `cpu_s`, `start_s`, index `seed`, by what they are of."""
    made_of = manifest.contents(have)
    if made_of is None:
        raise InputError(f"--have {have} holds no campaign; name a folder that `aeb-sumo campaign` has written")
    data = analysis.load(have)
    runs = data.runs.set_index("run_id")
    figures = analysis.run_figures(data)[["crashes", "km", "hours"]].assign(seed=runs["seed"])
    spent = journal.spent(have)
    for name in ("cpu_s", "start_s"):
        figures[name] = [getattr(spent[run], name) if run in spent else nan for run in figures.index]
    figures = figures[(runs["outcome"] == "completed") & figures.index.isin(list(made_of))]
    keys = figures.index.map(lambda run: alike(made_of[run]))
    return {str(key): part.set_index("seed") for key, part in figures.groupby(keys)}


def _from_runs(jobs: Sequence[Job], runs: pd.DataFrame, there: Collection[str]) -> _Group:
    hours = float(runs["hours"].mean())
    times = hours * 3600 if jobs[0].span is None else jobs[0].span
    longer = times / (3600 * hours) if hours else nan
    start, cpu = float(runs["start_s"].mean()), float(runs["cpu_s"].mean())
    left = sum(job.run_id not in there for job in jobs)
    return _Group(
        jobs=jobs, left=left, figures=runs[["crashes", "km"]].groupby(level=0).sum(),
        km=float(runs["km"].mean()) * longer, cpu_s=start + (cpu - start) * longer, runs=len(runs),
        shorter=longer > 1.01,
    )  # fmt: skip


def _from_pilot(jobs: Sequence[Job], pilot: Pilot) -> _Group:
    figures = analysis.run_figures(analysis.Dataset.of(pilot.results))[["crashes", "km"]]
    span = jobs[0].span
    return _Group(
        jobs=jobs, left=len(jobs), figures=figures.set_axis([jobs[0].settings.seed]),
        km=nan if span is None else pilot.km(span), cpu_s=nan if span is None else pilot.cpu_s(span), runs=0,
    )  # fmt: skip


def _pilots(jobs: Sequence[Job], seconds: float, workers: int, *, quiet: bool) -> list[Pilot]:
    if not jobs:
        return []
    terminal = Console(stderr=True)
    bar = Progress(console=terminal, disable=quiet or not terminal.is_terminal, transient=True)
    with interruptible(), ThreadPoolExecutor(workers) as executor, bar:
        task = bar.add_task(f"{len(jobs)} pilot runs", total=len(jobs))
        try:
            return pilots(jobs, seconds, executor, lambda _: bar.advance(task))
        except KeyboardInterrupt:
            raise click.Abort from None


def _print(groups: Sequence[_Group], title: str) -> None:
    table = Table(title=f"{title}: what is to be expected", title_justify="left")
    widest = max(len(group.jobs[0].group) for group in groups)
    table.add_column("", min_width=min(40, widest), overflow="fold")
    for name in ("runs", "core-hours", "vehicle-km", "crashes", "95 %", "per 10⁶ km", "against none"):
        table.add_column(name, justify="right")
    for group in groups:
        table.add_row(*_row(group, _baseline(group, groups)))
    console().print(table)


def _baseline(group: _Group, groups: Sequence[_Group]) -> _Group | None:
    """The runs of the same world without an AEB."""
    own = group.jobs[0].settings
    same = (g for g in groups if g.jobs[0].settings.world == own.world and g.jobs[0].content["strategy"] == "none")
    found = next(same, None)
    return None if found is group else found


def _row(group: _Group, baseline: _Group | None) -> list[str]:
    runs = len(group.jobs)
    km = runs * group.km
    cells = [group.jobs[0].group, str(runs), _number(runs * group.cpu_s / 3600), _number(km)]
    if isnan(km) or not km:
        return [*cells, "-", "-", "-", "-"]
    expected = forecast(group.figures, km=km)
    cells += [_number(expected.crashes), f"{_number(expected.low)} to {_number(expected.high)}"]
    if expected.rate:
        cells.append(f"{_number(_MILLION * expected.rate)} ± {_number(_MILLION * expected.half_width)}")
    else:
        cells.append(f"below {_number(_MILLION * expected.high / km)}")
    if baseline is None or isnan(baseline.km) or not baseline.figures["crashes"].any():
        return [*cells, "-"]
    width, paired = difference_half_width(
        baseline.figures, group.figures, seeds=runs, baseline_km=len(baseline.jobs) * baseline.km, km=km
    )
    change = expected.rate - forecast(baseline.figures, km=km).rate
    return [*cells, f"{_MILLION * change:+.0f} ± {_number(_MILLION * width)}" + ("" if paired else "*")]


def _print_cost(groups: Sequence[_Group], workers: int) -> None:
    runs, left = sum(len(g.jobs) for g in groups), sum(g.left for g in groups)
    hours = sum(g.left * g.cpu_s for g in groups) / 3600
    there = f"{runs - left} of them there, " if left < runs else ""
    click.echo(
        f"{runs} runs, {there}{left} to do: {_number(hours)} core-hours, about {_number(hours / workers)} h with "
        f"{workers} workers; {_number(sum(len(g.jobs) * g.km for g in groups))} vehicle-km in all."
    )


def _print_basis(groups: Sequence[_Group], pilot: float) -> None:
    """What it is based on, and how uncertain."""
    known, short = [g for g in groups if g.runs], [g for g in groups if not g.runs]
    if known:
        click.echo(f"{len(known)} rows are based on {sum(g.runs for g in known)} runs that are there.")
    if any(g.shorter for g in known):
        click.echo("Some of them are shorter than those to come: scaled by time, though traffic builds up at first.")
    if short:
        crashes = sum(float(g.figures["crashes"].sum()) for g in short)
        click.echo(
            f"{len(short)} rows are based on one pilot run each, of {pilot:g} s or the whole run if that is shorter, "
            f"with {crashes:.0f} crashes together: a guess. Traffic is taken to go on as in the last quarter of it; "
            "jams and pile-ups that come later are not in it, and crashes are taken as independent. A few runs of the "
            "campaign itself tell more: aeb-sumo plan --have DIR."
        )
    if any(float(g.figures["crashes"].sum()) < _FEW for g in groups):
        click.echo(
            f"Where fewer than {_FEW} crashes are known of, the rate and all that follows may be off by a factor."
        )
    click.echo("95 %: of the crashes to expect, as far as their rate is known. ±: half of the 95 % interval to come.")
    click.echo("*: rates taken as independent; seeds are paired from three runs of both on.")
    if any(isnan(g.km) for g in groups):
        click.echo("-: runs until all vehicles have arrived; give [run] duration_s.")


def _number(value: float) -> str:
    if isnan(value):
        return "-"
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"
