"""One campaign at a time in a folder."""

import fcntl
import os
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from aeb_sumo.campaign.inputs import digest
from aeb_sumo.errors import InputError
from aeb_sumo.results.place import Place

__all__ = ["inherited", "is_url", "locked"]

_NAME = ".lock"
_PATIENCE = 3.0  # s, our assumption: workers of a campaign that was killed notice it within a step
_held: set[int] = set()


def is_url(out: str) -> bool:
    """Whether results go to a file system of fsspec, not to a folder of this machine."""
    return Place.of(out).local is None


def inherited() -> tuple[int, ...]:
    """Open files by which workers of this process hold its locks, too.

    So a folder stays locked until the last of them is gone, however the campaign ended.
    """
    return tuple(_held)


@contextmanager
def locked(out: str) -> Iterator[None]:
    """Hold the lock of a results folder, which exists.

    The system gives it back when the process and its workers have ended, in whatever way. What lies behind a URL cannot
    be locked; then it is a file of this machine, and a campaign on another machine does not see it.

    Raises:
        InputError: another campaign holds it.
    """
    name = f"aeb-sumo-{os.getuid()}-{digest(out)}{_NAME}"
    path = (Place.of(out).local or Path(tempfile.gettempdir())) / (name if is_url(out) else _NAME)
    try:
        lock = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o644)
    except OSError as error:
        raise InputError(f"cannot lock {out}: {error.strerror}") from None
    try:
        _acquire(lock, out)
        os.truncate(lock, 0)
        os.pwrite(lock, f"{os.getpid()}\n".encode(), 0)
        _held.add(lock)
        yield
    finally:
        _held.discard(lock)
        os.close(lock)


def _acquire(lock: int, out: str) -> None:
    deadline = time.monotonic() + _PATIENCE
    while True:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() > deadline:
                holder = os.pread(lock, 32, 0).decode(errors="replace").strip()
                raise InputError(f"another campaign works in {out} (process {holder}); wait for its end") from None
            time.sleep(0.1)
        except OSError as error:  # a file system without locks
            raise InputError(f"cannot lock {out}: {error.strerror}") from None
        else:
            return
