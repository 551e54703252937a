"""One parameter of an AEB system at several values, in the same traffic: several runs at a time, judged."""

import signal
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from multiprocessing.synchronize import Event
from os import cpu_count
from typing import Any

from aeb_sumo import strategies
from aeb_sumo.equipment import Equipment, equipment
from aeb_sumo.results import Results
from aeb_sumo.scenarios import Scenario
from aeb_sumo.simulate import run

__all__ = ["sweep"]


def sweep(
    scenario: Scenario,
    strategy: str,
    name: str,
    values: Sequence[Any],
    *,
    seeds: Sequence[int],
    parameters: Mapping[str, Any] | None = None,
    sensing: str | None = None,
    penetration: float | None = None,
    duration: float | None = None,
    verdicts: str = "all",
    workers: int | None = None,
    done: Callable[[], None] | None = None,
) -> list[Results]:
    """Run a scenario with a parameter of a system at each of several values, and without AEB, for every seed.

    Args:
        scenario: what is simulated.
        strategy: the system.
        name: of the parameter, as `--set` has it.
        values: of the parameter; or of all runs but the baseline's.
        seeds: of the runs.
        parameters: other parameters that are not the system's defaults.
        sensing: suite; None for the system's own.
        penetration: share of cars equipped; None for all.
        duration: of each run [s]; None for the scenario's.
        verdicts: as `aeb_sumo.simulate.run` has them.
        workers: processes at a time; None for one per processor.
        done: called after every run.

    Returns:
        The results of all runs: the baseline's first, then value by value.

    Raises:
        InputError: the system has no such parameter, or a value, suite or share is out of range.
        SumoError: SUMO gave up.
    """
    systems = [strategies.load(strategy, {**(parameters or {}), name: value}) for value in values]
    carried = [equipment(system, sensing=sensing, penetration=penetration) for system in systems]
    jobs = [(each, seed) for each in (Equipment(), *carried) for seed in seeds]
    context = get_context("spawn")
    stop = context.Event()
    with ProcessPoolExecutor(
        workers or cpu_count(), mp_context=context, initializer=_begin, initargs=(stop,), max_tasks_per_child=1
    ) as pool:
        futures = [pool.submit(_run, scenario, each, seed, duration, verdicts) for each, seed in jobs]
        try:
            results = []
            for future in futures:
                results.append(future.result())
                if done is not None:
                    done()
        except BaseException:
            stop.set()  # also for a run that waits in the queue and cannot be cancelled any more
            pool.shutdown(cancel_futures=True)
            raise
    return results


_given_up: list[Event] = []  # in a worker: set when all runs are to end


def _begin(stop: Event) -> None:
    """The life of a worker begins."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C goes to all; the parent decides
    _given_up.append(stop)


def _run(scenario: Scenario, carried: Equipment, seed: int, duration: float | None, verdicts: str) -> Results:
    # The cores are taken by runs: one fork beside each.
    stop = _given_up[0].is_set
    return run(scenario, equip=carried, seed=seed, duration=duration, verdicts=verdicts, forks=1, stop=stop)
