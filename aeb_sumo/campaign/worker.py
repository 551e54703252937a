"""The process of one run: reads a job, simulates, writes its tables, says on the last line how it went."""

import ctypes
import json
import os
import resource
import signal
import sys
import time
import traceback
from math import ceil
from types import FrameType
from typing import Any

__all__ = ["main"]

_PR_SET_PDEATHSIG = 1
_BEYOND = 60.0  # s over its limit after which a worker ends even if nobody is left to kill it, our assumption


class _GivenUpError(BaseException):
    """The campaign has ended, or wants this run to end: nothing of it is to be kept."""


def main() -> None:
    """Run the job on standard input."""
    answer = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # whoever prints does not disturb the answer
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _give_up)
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, int(signal.SIGTERM))
    try:
        job = json.load(sys.stdin.buffer)
        signal.alarm(ceil(min(job["limit_s"] + _BEYOND, 2**31 - 1)))
        result = _run(job)
    except _GivenUpError:
        sys.exit(1)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # it is done
    answer.write(json.dumps(result) + "\n")
    answer.close()


def _give_up(number: int, frame: FrameType | None) -> None:  # noqa: ARG001
    raise _GivenUpError


def _run(job: dict[str, Any]) -> dict[str, Any]:
    """The outcome of a run."""
    from aeb_sumo.campaign.run import NotTheSameError, simulate  # noqa: PLC0415 - what takes long comes after the signals
    from aeb_sumo.errors import InputError  # noqa: PLC0415

    parent = job["parent"]

    started = 0.0

    def stop() -> bool:
        nonlocal started
        started = started or _spent()
        if os.getppid() != parent:
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


if __name__ == "__main__":
    main()
