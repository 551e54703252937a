"""One run in a process of its own: what an executor is given to do, here or on another machine."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from typing import Any

import aeb_sumo
from aeb_sumo.campaign.lock import inherited

__all__ = ["Outcome", "allow_workers", "end_workers", "execute"]

_GRACE = 5.0  # s, our assumption: that a worker has to end by itself when it is asked to
_LOOK = 0.5  # s between two looks whether a run is still wanted, our assumption
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")

_children: set["subprocess.Popen[bytes]"] = set()
_ending = False
_change = Lock()


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
    with _change:
        if _ending:
            return Outcome(run_id=job["run_id"], outcome="failed", reason="the campaign was ended")
        process = _start()
        _children.add(process)
    try:
        told = json.dumps({**job, "parent": os.getpid()}).encode()
        answer, messages = _wait(process, told, began + job["limit_s"], wanted)
        result = _read(answer) or {"outcome": "failed", "reason": _death(process.returncode, messages)}
    except subprocess.TimeoutExpired:
        _end([process])
        result = {"outcome": "failed", "reason": f"took longer than limit_s, {job['limit_s']:g} s, and was killed"}
    except _UnwantedError:
        _end([process])
        result = {"outcome": "failed", "reason": "nobody waits for it any more"}
    finally:
        with _change:
            _children.discard(process)
        _kill(process)
    return Outcome(run_id=job["run_id"], wall_s=time.monotonic() - began, **result)


class _UnwantedError(Exception):
    """Nobody waits for the run."""


def _wait(
    process: "subprocess.Popen[bytes]", told: bytes, deadline: float, wanted: Callable[[], bool]
) -> tuple[bytes, bytes]:
    """What a process says until its end."""
    first: bytes | None = told  # what it has not read yet is remembered
    while True:
        left = deadline - time.monotonic()
        try:
            return process.communicate(first, timeout=max(0.0, min(left, _LOOK)))
        except subprocess.TimeoutExpired:
            first = None
            if left <= _LOOK:
                raise
            if not wanted():
                raise _UnwantedError from None


def end_workers() -> None:
    """End all processes that `execute` has started in this process; from now on it starts none until `allow`."""
    global _ending  # noqa: PLW0603 - what threads of an executor are told
    with _change:
        _ending = True
        children = list(_children)
    _end(children)


def allow_workers() -> None:
    """Take `end_workers` back."""
    global _ending  # noqa: PLW0603
    with _change:
        _ending = False


def _start() -> "subprocess.Popen[bytes]":
    # The package that this process has, and nothing from the present folder.
    paths = [str(Path(aeb_sumo.__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
    environment = {**os.environ, **_ONE_THREAD, "PYTHONPATH": os.pathsep.join(filter(None, paths))}
    return subprocess.Popen(
        [sys.executable, "-P", "-m", "aeb_sumo.campaign.worker"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=environment,
        pass_fds=inherited(),
        start_new_session=True,  # Ctrl-C is for the campaign; and with its group, its forks can be killed, too
    )


def _end(processes: "Iterable[subprocess.Popen[bytes]]") -> None:
    """Ask them to end, so that they take away what is unfinished; those that do not are killed."""
    for process in processes:
        process.terminate()
    deadline = time.monotonic() + _GRACE
    for process in processes:
        try:
            process.wait(max(0.0, deadline - time.monotonic()))
        except subprocess.TimeoutExpired:
            _kill(process)


def _kill(process: "subprocess.Popen[bytes]") -> None:
    """If it is still there, with all that it has forked."""
    if process.poll() is None:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    for stream in (process.stdin, process.stdout, process.stderr):
        if stream is not None and not stream.closed:
            stream.close()


def _read(answer: bytes) -> dict[str, Any] | None:
    """What a worker said of its run last; None if it did not come to that."""
    lines = answer.decode(errors="replace").splitlines()
    try:
        found = json.loads(lines[-1])
    except (IndexError, ValueError):
        return None
    return found if isinstance(found, dict) else None


def _death(status: int, messages: bytes) -> str:
    """How a process ended that gave no answer."""
    lines = [line.strip() for line in messages.decode(errors="replace").splitlines() if line.strip()]
    last = f": {lines[-1]}" if lines else ""
    if status >= 0:
        return f"its process ended with status {status}{last}"
    number = signal.Signals(-status)
    return f"its process was ended by {number.name} ({signal.strsignal(number)}){last}"
