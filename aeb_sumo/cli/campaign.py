"""`aeb-sumo campaign`."""

import os
import signal
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from types import FrameType
from typing import Any

import click
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from aeb_sumo.campaign import manifest, runner
from aeb_sumo.campaign.cluster import cluster, execute_there
from aeb_sumo.campaign.execute import Outcome, execute
from aeb_sumo.campaign.expansion import Job, expand
from aeb_sumo.campaign.lock import is_url, locked
from aeb_sumo.campaign.spec import read
from aeb_sumo.errors import InputError
from aeb_sumo.results.place import Place

__all__ = ["campaign", "cores", "interruptible"]

_SHOWN = 10  # failed runs that are named at the end


@click.command()
@click.argument("spec", type=click.Path(path_type=Path))
@click.option("--out", required=True, help="Folder for the tables, new or of this campaign; or a URL of fsspec.")
@click.option("--dry-run", is_flag=True, help="List the runs that are missing, and do nothing.")
@click.option("--workers", type=click.IntRange(1), help="Runs at a time. [default: one per core]")
@click.option("--scheduler", metavar="tcp://HOST:PORT", help="Execute on this Dask cluster instead of here.")
@click.option("--retry-failed", is_flag=True, help="Execute again what failed before.")
@click.option("--quiet", is_flag=True, help="No progress bar, no summary.")
def campaign(
    spec: Path, out: str, dry_run: bool, workers: int | None, scheduler: str | None, retry_failed: bool, quiet: bool
) -> int:
    """Execute all runs of SPEC that are not in the folder yet; start it again after any end.

    SPEC is a TOML file: [factors] with scenario, strategy, seed and other options of `aeb-sumo run`, each a value or a
    list; [run] with what all runs have in common; [set.SYSTEM] with parameters. A folder belongs to one campaign, to
    which values may be added.
    """
    if scheduler is not None and workers is not None:
        raise InputError("--workers are those of this machine; with --scheduler there are as many as the cluster has")
    jobs = expand(read(spec))
    manifest.check(out, jobs)
    work = runner.split(jobs, out)
    before = runner.failed(out, work.there)
    if dry_run:
        again = [job for job in work.there if retry_failed and job.run_id in before]
        _list([*work.missing, *again], len(jobs), before)
        return 0
    if scheduler is None:
        return _execute(jobs, out, spec.stem, _local(workers), execute, retry_failed=retry_failed, quiet=quiet)
    with cluster(scheduler) as (executor, size):  # before the folder is made
        if not size:
            click.echo(f"aeb-sumo: note: {scheduler} has no workers yet; waiting for them", err=True)
        there = nullcontext(executor)
        return _execute(jobs, out, spec.stem, there, execute_there, retry_failed=retry_failed, quiet=quiet)


def _execute(
    jobs: Sequence[Job],
    out: str,
    name: str,
    executors: AbstractContextManager[Executor],
    how: Callable[[dict[str, Any]], Outcome],
    *,
    retry_failed: bool,
    quiet: bool,
) -> int:
    """Execute what is missing; the exit status."""
    _make(out)
    if is_url(out):
        click.echo(f"aeb-sumo: note: {out} is locked against a second campaign on this machine alone", err=True)
    try:
        with locked(out), interruptible():
            manifest.check(out, jobs)
            manifest.write(out, name, jobs)
            work = runner.split(jobs, out)
            before = runner.failed(out, work.there)
            if retry_failed:
                runner.forget(out, [job for job in jobs if job.run_id in before])
                work, before = runner.split(jobs, out), {}
            with executors as executor, _progress(len(jobs), len(work.there), quiet) as done:
                outcomes = runner.execute_all(work.missing, out, executor, how=how, done=done)
    except KeyboardInterrupt:
        click.echo("aeb-sumo: interrupted; finished runs are kept, and the same command does the rest", err=True)
        return 130
    failed = before | {each.run_id: each.reason for each in outcomes if each.outcome != "completed"}
    if not quiet:
        _summary(out, len(jobs), len(work.missing), failed)
    _name(failed, before)
    return 1 if failed else 0


def cores() -> int:
    """Those that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _list(missing: Sequence[Job], runs: int, failed: Mapping[str, str]) -> None:
    """What would be done."""
    for job in missing:
        settings = job.settings.plain()
        told = {**settings.pop("world"), **settings.pop("carried"), "seed": settings.pop("seed"), **settings}
        hidden = {"root", "interval_s"}
        words = (f"{key}={value}" for key, value in told.items() if key not in hidden and value not in (None, "", {}))
        click.echo(f"{job.run_id}  {' '.join(words)}")
    left = len(failed.keys() - {job.run_id for job in missing})
    ended = f", of which {left} failed (--retry-failed executes these again)" if left else ""
    click.echo(f"{runs} runs: {runs - len(missing)} are there{ended}, {len(missing)} would be executed")


def _make(out: str) -> None:
    folder = Place.of(out).local
    if folder is None:
        return
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make the folder --out {out}: {error.strerror}") from None


def _summary(out: str, runs: int, executed: int, failed: Mapping[str, str]) -> None:
    there = f", {runs - executed} were there before" if executed < runs else ""
    click.echo(f"{runs} runs: {runs - len(failed)} completed, {len(failed)} failed{there}.")
    click.echo(f"Tables in {out}: analysis.load('{out}')" + ("." if is_url(out) else f"; aeb-sumo report {out}."))


def _name(failed: Mapping[str, str], before: Mapping[str, str]) -> None:
    """Say which runs failed."""
    for run, reason in list(failed.items())[:_SHOWN]:
        when = " (before; --retry-failed executes it again)" if run in before else ""
        click.echo(f"aeb-sumo: failed{when}: {run}: {reason}", err=True)
    if len(failed) > _SHOWN:
        click.echo(f"aeb-sumo: failed: {len(failed) - _SHOWN} more, in table runs", err=True)


@contextmanager
def _local(workers: int | None) -> Iterator[Executor]:
    """A thread per run at a time, which waits for the run's process."""
    with ThreadPoolExecutor(workers or cores()) as executor:
        yield executor


@contextmanager
def interruptible() -> Iterator[None]:
    """Ctrl-C, and being asked to end, end the campaign once; a second Ctrl-C cannot stop it from ending its workers."""

    def ask(number: int, frame: FrameType | None) -> None:  # noqa: ARG001
        for each in (signal.SIGINT, signal.SIGTERM):
            signal.signal(each, signal.SIG_IGN)
        raise KeyboardInterrupt

    before = {each: signal.signal(each, ask) for each in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)


@contextmanager
def _progress(runs: int, there: int, quiet: bool) -> Iterator[Callable[[Outcome], None]]:
    console = Console(stderr=True)
    columns = (
        TextColumn("campaign"), BarColumn(), MofNCompleteColumn(), TextColumn("runs  {task.fields[rate]}"),
        TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn(elapsed_when_finished=False),
    )  # fmt: skip
    with Progress(*columns, console=console, disable=quiet or not console.is_terminal) as bar:
        task = bar.add_task("", total=runs, completed=there, rate="")
        ended, failed = 0, 0

        def done(outcome: Outcome) -> None:
            nonlocal ended, failed
            ended, failed = ended + 1, failed + (outcome.outcome != "completed")
            elapsed = bar.tasks[0].elapsed or 0.0
            rate = f"{3600 * ended / elapsed:.0f} per hour" if elapsed else ""
            bar.update(task, advance=1, rate=rate + (f", {failed} failed" if failed else ""))

        yield done
