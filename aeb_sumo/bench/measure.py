"""The measurements, each to be made in a process of its own: a world is warmed once, then stepped bare and equipped.

The two take turns of a few steps, so that what else the machine does meanwhile hits both alike.
"""

import tempfile
from collections.abc import Generator
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path
from time import process_time

from aeb_sumo.errors import InputError
from aeb_sumo.scenarios import Scenario
from aeb_sumo.scenarios.options import start_options
from aeb_sumo.world import bare
from aeb_sumo.world.session import Session

__all__ = ["Measured", "Stretch", "measure_bare", "measure_equipped", "warm"]

SETTLING = 10.0
"""Simulated between loading a world and the timed steps [s], our assumption: sensors then know what is around."""

# A process that has waited finds the processor's caches full of others' data: with turns of 10 steps SUMO by itself was
# measured 1.25 to 1.45 times as slow as without pauses, with 50 steps 1.05 times. A run does not pause, so turns are
# long and their first steps are not timed; they are short enough for what else the machine does to hit both alike.
_TURN = 100  # timed steps
_WAKING = 5  # steps before them


@dataclass(frozen=True, kw_only=True)
class Stretch:
    """What is stepped and timed.

    Attributes:
        scenario: starts with the saved world.
        begin: simulated time of the saved world [s].
        step_length: [s].
        steps: that are timed, after those that settle the world.
        sumo: version of SUMO.
    """

    scenario: Scenario
    begin: float
    step_length: float
    steps: int
    sumo: str

    @property
    def settling(self) -> int:
        """Steps that are simulated and not timed."""
        return max(1, round(SETTLING / self.step_length))

    @property
    def turns(self) -> list[int]:
        """Timed steps of each turn, before the other process goes on."""
        whole, rest = divmod(self.steps, _TURN)
        return [_TURN] * whole + [rest] * (rest > 0)


@dataclass(frozen=True, kw_only=True)
class Measured:
    """One measurement.

    Attributes:
        cpu: time of all threads for the timed steps [s].
        steps: that were timed.
        vehicle_steps: vehicles present, summed up over these steps.
        memory: largest resident size of the process [bytes].
    """

    cpu: float
    steps: int
    vehicle_steps: int
    memory: int


def warm(
    scenario: Scenario,
    state: Path,
    *,
    step_length: float | None,
    steps: int,
    at: float,
    vehicles: int | None = None,
    limit: float | None = None,
) -> Stretch:
    """Simulate a scenario bare, save the world, and say how to go on from there.

    Args:
        scenario: what is simulated.
        state: the file to save into; its folder takes all that the scenario makes SUMO write, too.
        step_length: [s]; None for the scenario's.
        steps: to be timed from there.
        at: simulated time since the scenario's begin from which on the world is saved [s] ...
        vehicles: ... as soon as so many are present; None for at once.
        limit: simulated time that is waited for them [s].

    Raises:
        InputError: so many are never present, nobody is, or SUMO refuses the scenario.
    """
    saving = replace(scenario, options=(*scenario.options, *bare.SAVING), output_prefix="")
    options = start_options(saving, state.parent, step_length=step_length)
    wanted = 1 if vehicles is None else vehicles
    with Session(options) as session:
        full = session.begin + at
        while session.time < full - session.dt / 2 or (limit is not None and bare.present() < wanted):
            if limit is not None and session.time > session.begin + limit:
                raise InputError(f"{wanted} vehicles were not present in {scenario.name} within {limit:g} s")
            session.step()
        if not bare.present():
            raise InputError(f"no vehicle is present in {scenario.name} at {session.time:g} s; choose another --from")
        bare.save(state.name)
        begin, dt, version = session.time, session.dt, session.version
    loaded = (*scenario.options, "--begin", f"{begin}", "--load-state", str(state))
    return Stretch(scenario=replace(scenario, options=loaded), begin=begin, step_length=dt, steps=steps, sumo=version)


def measure_bare(stretch: Stretch, other: Connection) -> Measured:
    """Step SUMO by itself: the same options and seed, nothing read, nothing commanded.

    Args:
        stretch: what is stepped.
        other: the end of a link to `measure_equipped`, with which it takes turns.
    """
    spent, vehicle_steps = 0.0, 0
    with tempfile.TemporaryDirectory() as nowhere:
        options = start_options(stretch.scenario, Path(nowhere), step_length=stretch.step_length)
        with Session(options):
            bare.timed_steps(stretch.settling)
            for turn in stretch.turns:
                other.recv()
                bare.timed_steps(_WAKING)
                cpu, vehicles = bare.timed_steps(turn)
                other.send(None)
                spent, vehicle_steps = spent + cpu, vehicle_steps + vehicles
    return Measured(cpu=spent, steps=stretch.steps, vehicle_steps=vehicle_steps, memory=_peak_memory())


def measure_equipped(stretch: Stretch, strategy: str, other: Connection) -> Measured:
    """The same as an ordinary run, with the AEB in every car and all books kept.

    Args:
        stretch: what is stepped.
        strategy: the AEB, by name.
        other: the end of a link to `measure_bare`, with which it takes turns.

    Raises:
        SumoError: SUMO gave up.
    """
    # Here, for the memory of what is stepped bare shall not hold it. pyarrow would import pandas with the first pack of
    # rows: once in a run, but perhaps within the few steps that are timed here.
    import pandas as pd  # noqa: F401, PLC0415

    from aeb_sumo.simulate import run  # noqa: PLC0415

    timed = _Timed()
    clock = _clock(stretch, other, timed)
    next(clock)
    with tempfile.TemporaryDirectory() as folder:
        results = run(
            stretch.scenario,
            strategy,
            step_length=stretch.step_length,
            duration=(stretch.settling + sum(_WAKING + turn for turn in stretch.turns)) * stretch.step_length,
            out=folder,
            progress=lambda step: clock.send(step.vehicles),
        )
    outcome, reason = results.runs[["outcome", "reason"]].iloc[0]
    if outcome != "completed":
        raise InputError(f"the run with {strategy} {outcome}: {reason}")
    return Measured(cpu=timed.cpu, steps=stretch.steps, vehicle_steps=timed.vehicle_steps, memory=_peak_memory())


@dataclass
class _Timed:
    """CPU time of the timed steps [s], and the vehicles present after each, summed up."""

    cpu: float = 0.0
    vehicle_steps: int = 0


def _clock(stretch: Stretch, other: Connection, timed: _Timed) -> Generator[None, int, None]:
    """Is told of every step of a run how many vehicles are present; lets the other process go in between."""
    for _ in range(stretch.settling):
        yield
    for turn in stretch.turns:
        other.send(None)
        other.recv()
        for _ in range(_WAKING):
            yield
        begin = process_time()
        for _ in range(turn):
            timed.vehicle_steps += yield
        timed.cpu += process_time() - begin
    yield


def _peak_memory() -> int:
    """Largest resident size of this process so far [bytes].

    Not `ru_maxrss`, which a process inherits from the one that started it.
    """
    status = Path("/proc/self/status").read_text(encoding="ascii")
    (kib,) = (line.split()[1] for line in status.splitlines() if line.startswith("VmHWM:"))
    return 1024 * int(kib)
