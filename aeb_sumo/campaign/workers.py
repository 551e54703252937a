"""The workers of this process: each simulates one run after the other, each of them in a fresh fork of itself."""

import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from threading import Lock
from typing import IO, cast

import aeb_sumo
from aeb_sumo.campaign.lock import inherited
from aeb_sumo.campaign.worker import TAKEN

__all__ = [
    "EndedError",
    "LeftError",
    "UnwantedError",
    "Worker",
    "allow_workers",
    "dismiss_idle",
    "end_workers",
    "give_back",
    "take",
]

_GRACE = 5.0  # s, our assumption: that a worker, with its run, has to end by itself when it is asked to
_LOOK = 0.5  # s between two looks whether a run is still wanted, our assumption
_READ = 1 << 16  # bytes at once
_LAST = 4096  # bytes of what a worker prints are kept
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


class UnwantedError(Exception):
    """Nobody waits for the run."""


class LeftError(Exception):
    """A worker has ended before it was asked."""


class EndedError(Exception):
    """The workers of this process have been ended."""


class Worker:
    """A process that executes jobs.

    Attributes:
        campaign: whose jobs: of another one, code and files may be others by now.
        last_words: the end of what it has said of its own.
    """

    def __init__(self, campaign: str) -> None:
        self.campaign = campaign
        # The package that this process has, and nothing from the present folder.
        paths = [str(Path(aeb_sumo.__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", "aeb_sumo.campaign.worker"],
            bufsize=0,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env={**os.environ, **_ONE_THREAD, "PYTHONPATH": os.pathsep.join(filter(None, paths))},
            pass_fds=inherited(),
            start_new_session=True,  # Ctrl-C is for the campaign; and with its group, its forks can be killed, too
        )
        self._process = process
        self._fresh = True  # it has answered nothing yet
        self.last_words = b""
        self._over = False
        self._stdin, self._stdout, self._stderr = (
            cast("IO[bytes]", stream) for stream in (process.stdin, process.stdout, process.stderr)
        )
        os.set_blocking(self._stderr.fileno(), False)

    def ask(self, job: bytes, deadline: float, wanted: Callable[[], bool]) -> bytes:
        """Its answer to a job: a line each; empty if it has ended instead.

        Raises:
            LeftError: it has been asked before, and has ended since then.
            TimeoutError: there is none by the deadline, as `time.monotonic` has it.
            UnwantedError: nobody waits for one any more.
        """
        with suppress(BrokenPipeError):
            self._stdin.write(job)
        answer, waiting = b"", select.poll()  # unlike `select`, with any number of open files
        for stream in (self._stdout, self._stderr):
            waiting.register(stream, select.POLLIN)
        while answer.count(b"\n") < 2:  # taken, and how it went
            left = deadline - time.monotonic()
            ready = [file for file, _ in waiting.poll(1000 * max(0.0, min(left, _LOOK)))]
            if self._stderr.fileno() in ready and not self._hear():
                waiting.unregister(self._stderr)
            data = os.read(self._stdout.fileno(), _READ) if self._stdout.fileno() in ready else None
            if data:
                answer += data
            elif data is not None or self.status is not None:  # a run that it left behind may still hold its output
                self.end(time.monotonic() + _GRACE)
                self._hear()
                if not answer and not self._fresh:
                    raise LeftError
                return b""
            elif left <= _LOOK:
                raise TimeoutError
            elif not wanted():
                raise UnwantedError
        self._fresh = False
        return answer.removeprefix(TAKEN)

    def _hear(self) -> bool:
        """Take in what it says of its own, so that it does not wait for a listener; False when it can say no more."""
        with suppress(BlockingIOError):
            while data := os.read(self._stderr.fileno(), _READ):
                self.last_words = (self.last_words + data)[-_LAST:]
            return False
        return True

    @property
    def status(self) -> int | None:
        """With which it has ended: negative, the signal that ended it; None if it has not."""
        return self._process.poll()

    def terminate(self) -> None:
        """Ask it to end, and to take away what is unfinished."""
        self._process.terminate()

    def end(self, deadline: float) -> None:
        """Wait for its end until then; it is killed if it is still there, and so is whom it has left behind."""
        if self._over:
            return
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(max(0.0, deadline - time.monotonic()))
        self._over = True  # another process may get its number now
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()

    def close(self) -> None:
        """Give back what it was connected by; not while somebody asks it."""
        for stream in (self._stdin, self._stdout, self._stderr):
            stream.close()


_all: set[Worker] = set()
_idle: list[Worker] = []
_ending = False
_change = Lock()


def take(campaign: str) -> Worker:
    """A worker that has nothing else to do.

    Raises:
        EndedError: `end_workers` has been called.
    """
    _bury()
    with _change:
        if _ending:
            raise EndedError
        for worker in reversed(_idle):
            if worker.campaign == campaign:
                _idle.remove(worker)
                return worker
        worker = Worker(campaign)
        _all.add(worker)
        return worker


def give_back(worker: Worker, *, usable: bool) -> None:
    """A worker has nothing to do any more; one that is not usable is ended."""
    _bury()
    with _change:
        usable = usable and not _ending
        if usable:
            _idle.append(worker)
    if not usable:
        _end([worker])
        worker.close()


def _bury() -> None:
    """Let go of those who have left."""
    with _change:
        gone = [each for each in _idle if each.status is not None]
        _idle[:] = [each for each in _idle if each not in gone]
        _all.difference_update(gone)
    for each in gone:
        each.close()


def dismiss_idle() -> None:
    """End the workers that have nothing to do."""
    with _change:
        workers = _idle.copy()
        _idle.clear()
    _end(workers)
    for each in workers:
        each.close()


def end_workers() -> None:
    """End all workers of this process; from now on there are none until `allow_workers`."""
    global _ending  # noqa: PLW0603 - what threads of an executor are told
    with _change:
        _ending = True
        busy = _all.difference(_idle)
    _end(busy)  # whoever waits for them closes them
    dismiss_idle()


def allow_workers() -> None:
    """Take `end_workers` back."""
    global _ending  # noqa: PLW0603
    with _change:
        _ending = False


def _end(workers: Iterable[Worker]) -> None:
    """Ask them to end, so that they take away what is unfinished; those that do not are killed."""
    for worker in workers:
        worker.terminate()
    deadline = time.monotonic() + _GRACE
    for worker in workers:
        worker.end(deadline)
    with _change:
        _all.difference_update(workers)
