"""One run in a process of its own: what an executor is given to do, here or on another machine."""

import json
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from aeb_sumo.campaign.worker import death
from aeb_sumo.campaign.workers import EndedError, LeftError, UnwantedError, give_back, take

__all__ = ["Outcome", "execute"]


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """How a run ended.

    Attributes:
        run_id: the run.
        outcome: `completed` or `failed`; `storage`: what it found could not be written; `mismatch`: the machine that
            should simulate it has other files or another program.
        reason: why it was not completed.
        in_tables: it has its row in `runs`.
        wall_s: time that it took.
        cpu_s: processor time that its process took, forks included.
        start_s: of that, before the first step had been simulated.
    """

    run_id: str
    outcome: str
    reason: str = ""
    in_tables: bool = False
    wall_s: float = 0.0
    cpu_s: float = 0.0
    start_s: float = 0.0


def execute(job: dict[str, Any], *, wanted: Callable[[], bool] = lambda: True) -> Outcome:
    """Simulate one run in a fresh process and wait for its end.

    Args:
        job: from `runner.payload`: only plain values, so that any executor can carry it anywhere.
        wanted: asked all the while; False ends the run, of which nothing is kept.

    Returns:
        The outcome, whatever happened to the process: it can crash, be killed or hang.
    """
    began = time.monotonic()
    result = None
    while result is None:
        with suppress(LeftError):
            result = _asked(job, began + job["limit_s"], wanted)
    return Outcome(run_id=job["run_id"], wall_s=time.monotonic() - began, **result)


def _asked(job: dict[str, Any], deadline: float, wanted: Callable[[], bool]) -> dict[str, Any]:
    """What a worker makes of a job.

    Raises:
        LeftError: the worker had left before it was asked.
    """
    usable = False
    try:
        worker = take(job["campaign"])
    except EndedError:
        return {"outcome": "failed", "reason": "the campaign was ended"}
    try:
        answer = worker.ask(json.dumps(job).encode() + b"\n", deadline, wanted)
        if not answer:
            return {"outcome": "failed", "reason": death(worker.status or 0, worker.last_words)}
        result: dict[str, Any] = json.loads(answer)
        usable = True
    except TimeoutError:
        return {"outcome": "failed", "reason": f"took longer than limit_s, {job['limit_s']:g} s, and was killed"}
    except UnwantedError:
        return {"outcome": "failed", "reason": "nobody waits for it any more"}
    else:
        return result
    finally:
        give_back(worker, usable=usable)
