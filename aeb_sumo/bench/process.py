"""A function in a process of its own, which nobody else's memory, caches or simulation can touch."""

import os
import signal
import tempfile
import traceback
from collections.abc import Callable
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import ParamSpec, TypeVar

from aeb_sumo.errors import InputError

__all__ = ["in_fresh_process"]

P = ParamSpec("P")
T = TypeVar("T")


def in_fresh_process(folder: Path, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
    """What a function returns that is called in a new process; the process is gone when this returns or raises.

    Args:
        folder: for the temporary files of the process.
        function: of a module, not nested; what it is given and returns can be pickled.
        args: for it.
        kwargs: for it.

    Raises:
        InputError: the function raised one, or its process was killed.
        RuntimeError: it raised anything else.
    """
    context = get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    child = context.Process(target=_answer, args=(sender, folder, function, args, kwargs), daemon=True)
    # Ctrl-C goes to all processes of the terminal. Blocked, it never reaches the child; the parent decides.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        child.start()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    sender.close()
    try:
        kind, value = receiver.recv()
    except EOFError:
        child.join()
        raise InputError(f"a measuring process ended early, with exit code {child.exitcode}") from None
    finally:
        child.kill()
        child.join()
        receiver.close()
    if kind == "returned":
        return value  # type: ignore[no-any-return]
    raise InputError(value) if kind == "refused" else RuntimeError(value)


def _answer(
    sender: Connection, folder: Path, function: Callable[..., T], args: tuple[object, ...], kwargs: dict[str, object]
) -> None:
    tempfile.tempdir = str(folder)
    with Path(os.devnull).open("wb") as nowhere:  # what SUMO warns of would tear the progress bar
        for stream in (1, 2):
            os.dup2(nowhere.fileno(), stream)
    try:
        answer: tuple[str, object] = "returned", function(*args, **kwargs)
    except InputError as error:
        answer = "refused", str(error)
    except Exception:  # told to the parent, whole
        answer = "failed", traceback.format_exc()
    sender.send(answer)
