"""Forking the world: a copy of this process, with the running SUMO in it, lives on and says what became of it."""

import fcntl
import gc
import os
import pickle
import select
import signal
import stat
import sys
import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from math import ceil
from typing import Any

import libsumo

__all__ = ["Answer", "Forks", "fork", "obstacle"]

_READ = 1 << 16  # bytes at once
_WAKE = b"!"


@dataclass(frozen=True)
class Answer:
    """What came of a fork: a value, or why there is none.

    Attributes:
        value: what the fork found.
        failure: why it did not; empty if it did.
    """

    value: Any = None
    failure: str = ""


@dataclass
class _Child:
    """A fork: its number, process, the end of the pipe that is read, and that of the one that wakes it."""

    number: int
    pid: int
    inward: int
    call: int
    started: float = 0.0
    data: bytes = b""


def fork() -> int:
    """`os.fork`, without a word about threads: Python sees those of the linear algebra, which expect forks."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        return os.fork()


def obstacle() -> str:
    """Why the running simulation cannot be forked; empty if it can.

    A fork copies one thread. SUMO must have no others, or the copy waits for them for ever.
    """
    if not sys.platform.startswith("linux"):
        return f"worlds are forked on Linux only, not on {sys.platform}"
    for option in ("threads", "device.rerouting.threads"):
        threads = int(libsumo.simulation.getOption(option))
        if threads > 1:
            return f"SUMO runs with {threads} {option}, and a world is forked with one only"
    return ""


class Forks:
    """Copies of the running world, so many at a time.

    Args:
        limit: forks that live at once; a further one waits for the first of them. None for one per core that is free
            beside this process, at least one.
        patience: after so many seconds of wall time a fork is given up, our assumption.
    """

    def __init__(self, limit: int | None = None, patience: float = 120.0) -> None:
        self._limit = max(1, _cores() - 1) if limit is None else limit
        self._patience = patience
        self._count = 0
        self._children: dict[int, _Child] = {}  # by the end of the pipe that is read
        self._asleep: dict[int, _Child] = {}  # by number
        self._answers: dict[int, Answer] = {}

    def __len__(self) -> int:
        """Forks that have not answered."""
        return len(self._children)

    @property
    def asleep(self) -> int:
        """Forks that have neither been woken nor dismissed; they are not bounded in number."""
        return len(self._asleep)

    def split(self, future: Callable[[], Any], *, asleep: bool = False) -> int:
        """Let a copy of this process compute `future()`, whose result must be picklable; the number of the fork.

        The copy answers and is gone; nothing that it does to the world is seen here.

        Args:
            future: the life of the copy.
            asleep: it does not begin before `wake`; until then it keeps the world as it is now.
        """
        number = self._split(future)
        if not asleep:
            self.wake(number)
        return number

    def wake(self, number: int) -> None:
        """Let a fork that is asleep begin."""
        while len(self._children) >= self._limit:
            self._collect(wait=True)
        child = self._asleep.pop(number, None)
        if child is not None:  # else it could not be made
            with suppress(BrokenPipeError):  # it has died meanwhile, which shows when it should answer
                os.write(child.call, _WAKE)
            os.close(child.call)
            child.started = time.monotonic()
            self._children[child.inward] = child

    def dismiss(self, number: int) -> None:
        """A fork that is asleep is not needed; there is no answer."""
        child = self._asleep.pop(number, None)
        if child is not None:
            os.close(child.call)
            self._bury(child, "not needed")
        self._answers.pop(number, None)  # there is none to take if it could not be made and has been reported

    def _split(self, future: Callable[[], Any]) -> int:
        self._count += 1
        sys.stdout.flush()
        sys.stderr.flush()
        ends: list[int] = []
        try:
            for _ in range(2):
                ends += os.pipe()
            inward, outward, listen, call = ends
            pid = fork()
        except OSError as error:
            for end in ends:
                os.close(end)
            self._answers[self._count] = Answer(failure=f"the world could not be forked: {error.strerror}")
            return self._count
        if pid == 0:
            os.close(call)
            _live(future, listen, outward, self._patience)
        os.close(outward)
        os.close(listen)
        self._asleep[self._count] = _Child(self._count, pid, inward, call)
        return self._count

    def answers(self, *, wait: bool = False) -> dict[int, Answer]:
        """Those that have come since the last call, by the number of the fork.

        Args:
            wait: for all that are still out.
        """
        if self._children:
            self._collect(wait=False)
        while wait and self._children:
            self._collect(wait=True)
        come, self._answers = self._answers, {}
        return come

    def end(self, why: str) -> None:
        """Give up all forks; the reason is their failure."""
        for number in list(self._asleep):
            self.dismiss(number)
        for child in list(self._children.values()):
            self._bury(child, why)

    def _collect(self, *, wait: bool) -> None:
        """Read what is there; `wait` until there is something."""
        now = time.monotonic()
        oldest = min(child.started for child in self._children.values())
        pause = max(0.0, oldest + self._patience - now) if wait else 0.0
        waiting = select.poll()  # unlike `select`, with any number of open files
        for inward in self._children:
            waiting.register(inward, select.POLLIN)
        for inward, _ in waiting.poll(1000 * pause):
            data = os.read(inward, _READ)
            self._children[inward].data += data
            if not data:
                self._bury(self._children[inward], "")
        for child in list(self._children.values()):
            if time.monotonic() - child.started > self._patience:
                self._bury(child, f"the fork was not done within {self._patience:g} s")

    def _bury(self, child: _Child, given_up: str) -> None:
        self._children.pop(child.inward, None)
        os.close(child.inward)
        if given_up:
            os.kill(child.pid, signal.SIGKILL)
        _, status = os.waitpid(child.pid, 0)
        self._answers[child.number] = Answer(failure=given_up) if given_up else _answer(child.data, status)


def _cores() -> int:
    """Those that this process may use; all, where the system does not say."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _answer(data: bytes, status: int) -> Answer:
    if os.WIFSIGNALED(status):
        return Answer(failure=f"the fork was ended by signal {os.WTERMSIG(status)}")
    try:
        answer = pickle.loads(data)  # noqa: S301 - from a copy of ourselves
    except (EOFError, pickle.UnpicklingError):
        return Answer(failure="the fork ended without an answer")
    return answer if isinstance(answer, Answer) else Answer(failure="the fork ended without an answer")


def _live(future: Callable[[], Any], listen: int, outward: int, patience: float) -> None:
    """The life of a fork; it ends here."""
    try:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C goes to all; the parent decides
        gc.disable()  # collecting would copy all memory that is shared
        _part_files(outward)
        if os.read(listen, 1) != _WAKE:  # not needed, or there is no parent any more
            return
        signal.alarm(ceil(patience) + 1)  # also when there is no parent any more to end it
        try:
            answer = Answer(future())
        except BaseException as error:
            answer = Answer(failure=" ".join(f"{type(error).__name__}: {error}".split()))
        with os.fdopen(outward, "wb") as pipe:
            pickle.dump(answer, pipe)
    finally:
        os._exit(0)


def _part_files(keep: int) -> None:
    """Part from the parent's open files.

    A fork shares them, position and all: SUMO goes on reading routes while it runs, and would take them away from the
    parent; and what it wrote would end up in the parent's files.
    """
    nowhere = os.open(os.devnull, os.O_RDWR)
    for fd in [int(name) for name in os.listdir("/proc/self/fd")]:  # noqa: PTH208 - numbers, not paths
        if fd in (keep, nowhere):
            continue
        try:
            mode, flags = os.fstat(fd).st_mode, fcntl.fcntl(fd, fcntl.F_GETFL)
        except OSError:  # the listing's own
            continue
        if flags & os.O_ACCMODE != os.O_RDONLY:
            os.dup2(nowhere, fd)
        elif stat.S_ISREG(mode):
            own = os.open(f"/proc/self/fd/{fd}", os.O_RDONLY)
            os.lseek(own, os.lseek(fd, 0, os.SEEK_CUR), os.SEEK_SET)
            os.dup2(own, fd)
            os.close(own)
