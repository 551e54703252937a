"""Executes what is missing of a campaign, on any executor of `concurrent.futures`."""

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, as_completed
from dataclasses import dataclass, replace
from typing import Any
from uuid import uuid4

from aeb_sumo.campaign import journal
from aeb_sumo.campaign.execute import Outcome, execute
from aeb_sumo.campaign.expansion import Job
from aeb_sumo.campaign.failure import row_of
from aeb_sumo.campaign.workers import allow_workers, dismiss_idle, end_workers
from aeb_sumo.errors import InputError
from aeb_sumo.results.place import Place
from aeb_sumo.results.reader import Stored
from aeb_sumo.results.store import commit_failure, finished

__all__ = ["Work", "execute_all", "failed", "forget", "payload", "split"]


@dataclass(frozen=True, kw_only=True)
class Work:
    """What there is to do.

    Attributes:
        there: runs of the campaign that exist.
        missing: those that do not.
    """

    there: Sequence[Job]
    missing: Sequence[Job]


def split(jobs: Sequence[Job], out: str) -> Work:
    """Which runs exist, and which do not.

    Raises:
        InputError: the folder cannot be listed.
    """
    there = finished(out)
    return Work(
        there=[job for job in jobs if job.run_id in there], missing=[job for job in jobs if job.run_id not in there]
    )


def payload(job: Job, out: str, campaign: str = "") -> dict[str, Any]:
    """A job of a campaign as plain values, as `execute` takes it; the present folder is another one there."""
    local = Place.of(out).local
    out = out if local is None else str(local.absolute())
    return {
        "run_id": job.run_id, "out": out, "settings": job.settings.plain(), "content": dict(job.content),
        "limit_s": job.limit_s, "campaign": campaign,
    }  # fmt: skip


def execute_all(
    jobs: Sequence[Job],
    out: str,
    executor: Executor,
    *,
    how: Callable[[dict[str, Any]], Outcome] = execute,
    done: Callable[[Outcome], None] = lambda _: None,
) -> list[Outcome]:
    """Execute some runs; one that dies or fails gets a row that says so, and the others go on.

    Args:
        jobs: the runs.
        out: folder or URL for the tables.
        executor: in this process or elsewhere; a thread per run is enough, as it only waits.
        how: what it is given to do.
        done: called after every run.

    Returns:
        Their outcomes, in the order in which they ended.

    Raises:
        InputError: results cannot be written, or the executor has other files or another program. What was finished
            until then is kept.
    """
    allow_workers()
    campaign = uuid4().hex  # another time, code and files may be others
    futures: dict[Future[Outcome], Job] = {}
    outcomes = []
    try:
        for job in jobs:
            futures[executor.submit(how, payload(job, out, campaign))] = job
        for future in as_completed(futures):
            outcome = _kept(_outcome(future, futures[future]), futures[future], out)
            journal.note(out, outcome)
            outcomes.append(outcome)
            done(outcome)
    except BaseException:
        for future in futures:
            future.cancel()
        end_workers()
        raise
    dismiss_idle()
    return outcomes


def _outcome(future: "Future[Outcome]", job: Job) -> Outcome:
    """How a run ended; an executor can lose it, too."""
    try:
        error = future.exception()
    except CancelledError as cancelled:
        error = cancelled
    if error is None:
        return future.result()
    if isinstance(error, ImportError):
        raise InputError(f"where runs are executed, this program is missing: {error}")
    if isinstance(error, BrokenExecutor | CancelledError):
        raise InputError(f"the executor of the runs is gone; finished runs are kept: start it {_AGAIN}")
    return Outcome(run_id=job.run_id, outcome="failed", reason=" ".join(f"{type(error).__name__}: {error}".split()))


def _kept(outcome: Outcome, job: Job, out: str) -> Outcome:
    """The outcome, with a row in `runs`."""
    if outcome.outcome == "storage":
        raise InputError(f"cannot write into {out}: {outcome.reason}; finished runs are kept: make room {_AGAIN}")
    if outcome.outcome == "mismatch":
        raise InputError(f"run {outcome.run_id} would be another one where it is executed: {outcome.reason}")
    there = Place.of(out).holds("runs", job.run_id)
    if outcome.in_tables and not there:
        raise InputError(
            f"run {job.run_id} was written where it was executed, but is not in {out} here; name a folder or URL that "
            "all processes and machines share"
        )
    if outcome.in_tables:
        return outcome
    if there:  # what died had nothing left to do but to say so
        reason = failed(out, [job]).get(job.run_id)
        ended = "completed" if reason is None else "failed"
        return replace(outcome, outcome=ended, reason=reason or "", in_tables=True)
    commit_failure(out, row_of(job.run_id, job.settings, outcome.reason))
    return outcome


_AGAIN = "and start the same command again"


def failed(out: str, jobs: Sequence[Job]) -> dict[str, str]:
    """Of some runs that exist, those that were not completed -> reason.

    Raises:
        InputError: their rows cannot be read.
    """
    if not jobs:
        return {}
    runs = Stored.of(out).only([job.run_id for job in jobs])
    rows = runs.read("runs", columns=["run_id", "outcome", "reason"], filters=[("outcome", "!=", "completed")])
    return {row["run_id"]: row["reason"] or row["outcome"] for row in rows.to_pylist()}


def forget(out: str, jobs: Iterable[Job]) -> None:
    """Take some runs away, so that they are missing.

    Raises:
        InputError: they cannot be.
    """
    place = Place.of(out)
    for job in jobs:
        place.remove("runs", job.run_id)
