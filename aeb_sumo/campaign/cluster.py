"""A campaign on a Dask cluster: each of its workers does what `execute` does here."""

import logging
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from typing import Any

from aeb_sumo.campaign.execute import Outcome, execute
from aeb_sumo.campaign.identity import code
from aeb_sumo.errors import InputError

__all__ = ["cluster", "execute_there"]

_PATIENCE = 10.0  # s for the scheduler to answer, our assumption
_GONE = {"cancelled", "released", "forgotten"}
"""States of a task of Dask that nobody waits for any more."""


@contextmanager
def cluster(address: str) -> "Iterator[tuple[Executor, int]]":
    """An executor on a cluster, to be given `execute_there`, and how many runs it takes at a time now.

    Args:
        address: of the scheduler, such as `tcp://host:8786`.

    Raises:
        InputError: Dask is not installed, the scheduler cannot be reached, or a worker of it has another program.
    """
    try:
        from distributed import Client  # noqa: PLC0415 - an extra
    except ImportError:
        raise InputError("--scheduler needs Dask: pip install 'aeb-sumo[distributed]'") from None
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # what it has to say is said here, in one line
    try:
        connect: Any = Client  # Dask's is typed in part
        client = connect(address, timeout=_PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"--scheduler {address} cannot be reached: {reason}") from None
    try:
        _check(client, address)
        yield client.get_executor(pure=False), sum(client.nthreads().values())
    finally:
        client.close()


def _check(client: Any, address: str) -> None:
    """The workers that are there have this program."""
    here = code()
    for worker, found in client.run(code, on_error="return").items():
        if isinstance(found, BaseException):
            found = {"error": f"{type(found).__name__}: {found}"}  # noqa: PLW2901
        if found != here:
            raise InputError(f"--scheduler {address}: its worker {worker} has {found}, not {here} as here")


def execute_there(job: dict[str, Any]) -> Outcome:
    """`execute`, in a worker of Dask; it ends when nobody waits for the outcome any more.

    That is so when the campaign has ended, in whatever way: the next one may want to simulate the same run.
    """
    return execute(job, wanted=_waited_for())


def _waited_for() -> Callable[[], bool]:
    """Whether the task that is executed in this thread is still one."""
    from distributed import get_worker  # noqa: PLC0415

    worker = get_worker()
    key = worker.get_current_task()

    def wanted() -> bool:
        task = worker.state.tasks.get(key)
        return task is not None and task.state not in _GONE

    return wanted
