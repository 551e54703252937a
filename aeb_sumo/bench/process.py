"""Functions in processes of their own, which nobody else's memory or simulation can touch."""

import os
import signal
import tempfile
import traceback
from collections.abc import Callable, Iterable, Sequence
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, TypeVar

from aeb_sumo.errors import InputError

__all__ = ["in_fresh_processes", "link"]

T = TypeVar("T")
_CONTEXT = get_context("spawn")


def link() -> tuple[Connection, Connection]:
    """Two ends for two processes to talk to each other; `in_fresh_processes` closes them on this side.

    Who finds the other gone gets an `EOFError` or a `ConnectionError`.
    """
    return _CONTEXT.Pipe()


def in_fresh_processes(folder: Path, tasks: Sequence[Callable[[], T]], links: Sequence[Connection] = ()) -> list[T]:
    """What tasks return, each of which is called in a new process, all at a time; these are gone when this ends.

    Args:
        folder: for the temporary files of the processes.
        tasks: can be pickled, and what they return, too.
        links: that they hold.

    Raises:
        InputError: a task raised one, or its process was killed.
        RuntimeError: it raised anything else.
    """
    started: dict[Connection, BaseProcess] = {}
    try:
        for task in tasks:
            receiver, sender = _CONTEXT.Pipe(duplex=False)
            started[receiver] = _start(sender, folder, task)
        for end in links:
            end.close()  # so that a process notices when the other is gone
        answers: dict[Connection, tuple[str, Any]] = {}
        while waiting := [receiver for receiver in started if receiver not in answers]:
            ready = wait(waiting)
            answers |= {one: _answer_of(one, started[one]) for one in waiting if one in ready}
            _check(answers.values(), ("refused", "failed"))
        _check(answers.values(), ("lost",))
        return [answers[receiver][1] for receiver in started]
    finally:
        for receiver, process in started.items():
            process.kill()
            process.join()
            receiver.close()


def _start(sender: Connection, folder: Path, task: Callable[[], Any]) -> BaseProcess:
    process = _CONTEXT.Process(target=_answer, args=(sender, folder, task), daemon=True)
    # Ctrl-C goes to all processes of the terminal. Blocked, it never reaches this one; its parent decides.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        process.start()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    sender.close()
    return process


def _answer_of(receiver: Connection, process: BaseProcess) -> tuple[str, Any]:
    try:
        answer: tuple[str, Any] = receiver.recv()
    except EOFError:
        process.join()
        return "refused", f"a measuring process ended early, with exit code {process.exitcode}"
    return answer


def _check(answers: Iterable[tuple[str, Any]], errors: Sequence[str]) -> None:
    for kind, value in answers:
        if kind in errors:
            raise InputError(value) if kind == "refused" else RuntimeError(value)


def _answer(sender: Connection, folder: Path, task: Callable[[], Any]) -> None:
    """The life of a process."""
    tempfile.tempdir = str(folder)
    with Path(os.devnull).open("wb") as nowhere:  # what SUMO warns of would tear the progress bar
        for stream in (1, 2):
            os.dup2(nowhere.fileno(), stream)
    try:
        answer: tuple[str, Any] = "returned", task()
    except InputError as error:
        answer = "refused", str(error)
    except Exception as error:
        # Who finds the other end of a link gone is not to blame; the answer of the other says more.
        lost = isinstance(error, EOFError | ConnectionError)
        answer = "lost" if lost else "failed", traceback.format_exc()
    sender.send(answer)
