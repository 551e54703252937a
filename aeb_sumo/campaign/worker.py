"""A worker of a campaign: has at hand what runs need, and lets a fresh fork of itself simulate each of them.

libsumo holds one world per process, and to get ready takes longer than a short run. So a worker never starts SUMO
itself: for every job on standard input it forks a process that simulates it, writes its tables and is gone; on standard
output the worker says how it went. What is calculated once for a system the worker has calculated before; what a run
had to import and compile, it imports and compiles after it: the next one has all that from the beginning.
"""

import ctypes
import gc
import json
import os
import pickle
import resource
import select
import signal
import sys
import time
import traceback
from collections.abc import Iterator
from contextlib import suppress
from importlib import import_module
from math import ceil
from types import FrameType
from typing import Any

__all__ = ["TAKEN", "death", "main"]

TAKEN = b"taken\n"
"""What a worker says when it begins with a job; it says how that ended in another line."""

_PR_SET_PDEATHSIG = 1
_BEYOND = 60.0  # s over its limit after which a run ends even if nobody is left to kill it, our assumption
_IDLE = 20.0  # s without a job after which a worker ends, our assumption: somebody else may have use for the memory
_GRACE = 3.0  # s, our assumption: that a run has to end by itself when it is asked to
_LOOK = 0.02  # s between two looks whether it has
_READ = 1 << 16  # bytes at once
_LAST = 4096  # bytes of what a run prints are kept: its last words


class _GivenUpError(BaseException):
    """The campaign has ended, or wants this run to end: nothing of it is to be kept."""


def main() -> None:
    """Have the jobs on standard input simulated, until there are no more."""
    answers = os.fdopen(os.dup(1), "wb", buffering=0)
    os.dup2(2, 1)  # whoever prints does not disturb the answers
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _give_up)
    try:
        from aeb_sumo.campaign.run import get_ready  # noqa: PLC0415 - what takes long comes after the signals

        get_ready()
        for job in _jobs():
            answers.write(TAKEN)
            result, lesson = _simulated(job, answers.fileno())
            answers.write(json.dumps(result).encode() + b"\n")
            with suppress(Exception):  # then the next run has to do it again
                _learn(lesson)
    except (_GivenUpError, BrokenPipeError):
        sys.exit(1)


def _give_up(number: int, frame: FrameType | None) -> None:  # noqa: ARG001
    raise _GivenUpError


def _jobs() -> Iterator[dict[str, Any]]:
    """A line each; the next one comes when the last is answered."""
    line = b""
    while _readable([0], _IDLE) and (data := os.read(0, _READ)):
        line += data
        if line.endswith(b"\n"):
            yield json.loads(line)
            line = b""


def _readable(files: list[int], patience: float | None = None) -> list[int]:
    """Of some files those with something to read, or at their end; none after so many seconds."""
    return select.select(files, [], [], patience)[0]


def _simulated(job: dict[str, Any], answers: int) -> tuple[dict[str, Any], bytes]:
    """The outcome of a job, whatever happens to its process, and what there is to learn from it.

    Args:
        job: from `runner.payload`.
        answers: which the process of the run has no part in.

    Raises:
        _GivenUpError: nobody waits for it any more.
    """
    from aeb_sumo.campaign.run import prepare  # noqa: PLC0415
    from aeb_sumo.world.fork import fork  # noqa: PLC0415

    with suppress(Exception):  # the run will say why
        prepare(job)
    gc.freeze()  # what is here now is shared with all forks, and collecting it would copy it
    (inward, outward), (heard, said) = os.pipe(), os.pipe()
    worker, run = os.getpid(), fork()
    if run == 0:
        status = 1
        try:
            for end in (answers, inward, heard):
                os.close(end)
            _live(job, worker, outward, said)
            status = 0
        except Exception:
            traceback.print_exc()
        finally:
            os._exit(status)
    for end in (outward, said):
        os.close(end)
    try:
        told, messages = _listen(inward, heard)
    except _GivenUpError:
        _end(run)
        raise
    finally:
        status = os.waitstatus_to_exitcode(os.waitpid(run, 0)[1])
        for end in (inward, heard):
            os.close(end)
    result, complete, lesson = told.partition(b"\n")
    if not complete:
        return {"outcome": "failed", "reason": death(status, messages)}, b""
    return json.loads(result), lesson


def _end(run: int) -> None:
    """Ask a run to end, so that it takes away what is unfinished; one that does not is killed."""
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # once is enough
    os.kill(run, signal.SIGTERM)
    deadline = time.monotonic() + _GRACE
    while os.waitid(os.P_PID, run, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None:
        if time.monotonic() > deadline:
            os.kill(run, signal.SIGKILL)
            return
        time.sleep(_LOOK)


def _listen(inward: int, heard: int) -> tuple[bytes, bytes]:
    """What a run tells until its end, and its last words."""
    told, messages, there = b"", b"", [0, inward, heard]
    while len(there) > 1:
        for file in _readable(there):
            if file == 0:  # there is no other job before this one is answered, so it is the end of the campaign
                raise _GivenUpError
            data = os.read(file, _READ)
            if not data:
                there.remove(file)
            elif file == inward:
                told += data
            else:
                messages = (messages + data)[-_LAST:]
    return told, messages


def _learn(lesson: bytes) -> None:
    """Have from now on what a run had to import and compile."""
    from aeb_sumo import compiled  # noqa: PLC0415

    modules, kernels = pickle.loads(lesson)  # noqa: S301 - from a copy of ourselves
    for name in modules:
        with suppress(Exception):  # made up by somebody, and not to be imported by its name
            import_module(name)
    compiled.prepare(kernels)


def _live(job: dict[str, Any], worker: int, outward: int, said: int) -> None:
    """The life of the process of a run: simulates, and says in a line how that went, and then what it had to learn."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, int(signal.SIGTERM))
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(said, 1)
    os.dup2(said, 2)
    signal.alarm(ceil(min(job["limit_s"] + _BEYOND, 2**31 - 1)))
    before = set(sys.modules)
    result = _result(job, worker)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # it is done
    for stream in (sys.stdout, sys.stderr):
        with suppress(Exception):  # closed by somebody
            stream.flush()
    with os.fdopen(outward, "wb") as pipe:
        pipe.write(json.dumps(result).encode() + b"\n")
        pipe.flush()
        from aeb_sumo import compiled  # noqa: PLC0415

        pickle.dump(([name for name in sys.modules if name not in before], compiled.known()), pipe)


def _result(job: dict[str, Any], worker: int) -> dict[str, Any]:
    from aeb_sumo.campaign.run import NotTheSameError, simulate  # noqa: PLC0415
    from aeb_sumo.errors import InputError  # noqa: PLC0415

    started = 0.0

    def stop() -> bool:
        nonlocal started
        started = started or _spent()
        if os.getppid() != worker:
            raise _GivenUpError
        return False

    try:
        outcome, reason = simulate(job, stop)
    except Exception as error:
        if said := _storage(error):
            return {"outcome": "storage", "reason": said}
        if isinstance(error, NotTheSameError):
            return {"outcome": "mismatch", "reason": str(error)}
        if not isinstance(error, InputError):
            traceback.print_exc()
            return {"outcome": "failed", "reason": " ".join(f"{type(error).__name__}: {error}".split())}
        return {"outcome": "failed", "reason": str(error)}
    spent = {"cpu_s": _spent(), "start_s": started}
    return {"outcome": outcome, "reason": reason, "in_tables": True, **spent}


def _spent() -> float:
    """Processor time of this process, and of its forks that have ended [s]."""
    forks = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + forks.ru_utime + forks.ru_stime


def _storage(error: BaseException | None) -> str:
    """Why nothing can be written any more; empty if that is not what an error comes from."""
    from errno import EDQUOT, EFBIG, ENOSPC, EROFS  # noqa: PLC0415

    while error is not None:
        if isinstance(error, OSError) and error.errno in {ENOSPC, EDQUOT, EFBIG, EROFS}:
            place = f" ({error.filename})" if isinstance(error.filename, str) else ""
            return os.strerror(error.errno) + place
        error = error.__cause__ or error.__context__
    return ""


def death(status: int, messages: bytes) -> str:
    """How a process ended that gave no answer."""
    lines = [line.strip() for line in messages.decode(errors="replace").splitlines() if line.strip()]
    last = f": {lines[-1]}" if lines else ""
    if status >= 0:
        return f"its process ended with status {status}{last}"
    name = next((each.name for each in signal.Signals if each == -status), f"signal {-status}")
    return f"its process was ended by {name} ({signal.strsignal(-status)}){last}"


if __name__ == "__main__":
    main()
