"""One run, from a scenario to tables."""

import tempfile
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

import aeb_sumo
from aeb_sumo.engine import Engine
from aeb_sumo.equipment import Equipment, equipment
from aeb_sumo.errors import InputError
from aeb_sumo.fleet import Target
from aeb_sumo.ledger.conflicts import Conflicts
from aeb_sumo.ledger.crashes import Crashes
from aeb_sumo.ledger.interventions import Action, Intervention, Interventions
from aeb_sumo.ledger.rows import Rows
from aeb_sumo.ledger.traffic import TrafficBook
from aeb_sumo.perception.suites import Suite
from aeb_sumo.results import Results
from aeb_sumo.results.writer import Writer
from aeb_sumo.scenarios import Scenario
from aeb_sumo.scenarios.options import start_options
from aeb_sumo.strategies.base import Strategy
from aeb_sumo.trace import Recorder
from aeb_sumo.verdicts import Choice, Verdicts
from aeb_sumo.world.fork import Forks
from aeb_sumo.world.session import Session, SumoError
from aeb_sumo.world.surroundings import lane
from aeb_sumo.world.wrecks import Crash

__all__ = ["POLLS", "Progress", "run"]

POLLS = ("needed", "every")
"""Whom to read in a step; see `run`."""

_BLOCKAGE = 60.0  # s, our assumption


@dataclass(frozen=True)
class Progress:
    """How far a run is: simulated time since its begin [s] and in all (None: unknown), vehicles now, events so far."""

    time: float
    duration: float | None
    vehicles: int
    crashes: int
    interventions: int


def run(
    scenario: Scenario,
    strategy: str | Strategy | None = None,
    *,
    penetration: float | None = None,
    seed: int | None = None,
    duration: float | None = None,
    step_length: float | None = None,
    blockage: float | None = None,
    interval: float = 60.0,
    sensing: str | Suite | None = None,
    equip: str | Equipment | None = None,
    verdicts: str = "none",
    forks: int | None = None,
    poll: str = "needed",
    trace: Recorder | None = None,
    sumo_output: Path | None = None,
    progress: Callable[[Progress], None] | None = None,
    stop: Callable[[], bool] | None = None,
    out: str | None = None,
    run_id: str | None = None,
) -> Results:
    """Simulate a scenario with an AEB fleet.

    Args:
        scenario: what is simulated.
        strategy: the AEB, or its name; "none" is the baseline, None for zhao2025.
        penetration: share of cars equipped, 0 to 1; None for all of them. A car that is equipped at one share is so at
            every larger one.
        seed: of SUMO and of the drivers; None for the scenario's.
        duration: [s]; None for the scenario's.
        step_length: [s]; None for the scenario's.
        blockage: how long crashed vehicles stand before they leave [s]; None for 60, our assumption, or for SUMO's
            time-to-teleport if that is shorter.
        interval: of the rows of table `traffic` [s].
        sensing: what the equipped vehicles see with, a suite or its name; None for the strategy's own.
        equip: instead of these three, several systems in one run, or shares by kind of vehicle: an `Equipment` or its
            text, such as `zhao2025=0.3,yan2025=0.2` or `passenger:zhao2025=0.5,truck:zhao2025/radar=0.2`.
        verdicts: which interventions are judged by a fork of the world in which they do not take place: `all`, `none`,
            or `sample:N`, a random sample of that many per run. No other column of any table depends on it.
        forks: that live at once, beside the run; None for one per core that is free, at least one.
        poll: whom to read in a step: `needed`, those with whom a conflict is possible, all others once per search cycle
            of the sensors (`aeb_sumo.world.leads`); or `every`, everyone, which is slow and gives the same.
        trace: looks on, for example an `aeb_sumo.trace.Trace`.
        sumo_output: folder for the output files that the scenario itself asks of SUMO; None throws them away.
        progress: called after every step.
        stop: asked after every step; True ends the run, whose tables are then marked as interrupted.
        out: folder or fsspec URL that the rows go to as they come, so that memory does not grow with the duration; the
            run is there when it has ended, as a whole, and takes the place of one of its id. None keeps them in memory.
        run_id: name of the run in all tables; None for one made of scenario, equipment and seed.

    Returns:
        The tables of `aeb_sumo.results.TABLES`, one run; with `out`, all but `runs` without rows.

    Raises:
        InputError: an argument is out of range, a strategy, suite or kind of vehicle is unknown, SUMO refuses the
            scenario, or `out` cannot be written to.
    """
    carried = equipment(strategy, sensing=sensing, penetration=penetration, equip=equip)
    for name, value in (("duration", duration), ("step length", step_length), ("interval", interval)):
        if value is not None and not 0 < value < np.inf:
            raise InputError(f"{name} must be a positive number of seconds, not {value:g}")
    if blockage is not None and not 0 <= blockage < np.inf:
        raise InputError(f"blockage must be 0 or more seconds, not {blockage:g}")
    choice = Choice.parse(verdicts)
    if poll not in POLLS:
        raise InputError(f"unknown poll {poll!r}; there are: {', '.join(POLLS)}")
    with tempfile.TemporaryDirectory() as nowhere:
        options = start_options(scenario, Path(nowhere), seed=seed, step_length=step_length, output=sumo_output)
        with Session(options) as session:
            span = scenario.duration if duration is None else duration
            # SUMO would put a wreck that stands for too long elsewhere.
            limit = session.time_to_teleport
            if blockage is not None and blockage > limit:
                raise InputError(f"blockage {blockage:g} s is longer than SUMO's time-to-teleport of {limit:g} s")
            stand = min(_BLOCKAGE, limit) if blockage is None else blockage
            carried.check_kinds(session.vehicle_types)
            name = "-".join(filter(None, (Path(scenario.name).stem, scenario.variation)))
            identity = carried.run_id(name, session.seed) if run_id is None else run_id
            one = _Run(
                session, scenario, carried, stand, interval, trace, choice, forks, identity, every=poll == "every"
            )
            with nullcontext() if out is None else Writer(out, identity) as writer:
                try:
                    return one.simulate(span, progress, stop, writer)
                finally:
                    one.end_forks()


class _Run:
    """An engine, and the books that are kept of it."""

    def __init__(
        self,
        session: Session,
        scenario: Scenario,
        carried: Equipment,
        blockage: float,
        interval: float,
        trace: Recorder | None,
        choice: Choice,
        forks: int | None,
        run_id: str,
        *,
        every: bool,
    ) -> None:
        self._session, self._scenario, self._carried = session, scenario, carried
        self._blockage, self._run_id = blockage, run_id
        self._engine = engine = Engine(session, scenario, carried, blockage, every=every)
        self._conflicts = Conflicts(engine.traffic, engine.error, scenario.mu)
        self._verdicts = (
            Verdicts(engine, self._conflicts, choice=choice, forks=Forks(forks))
            if choice.size and carried.systems
            else None
        )
        self._interventions = Interventions(judged=self._verdicts is not None)
        self._book = TrafficBook(engine.traffic, session.begin, interval)
        self._crashes = Crashes(engine.traffic, engine.fleet, engine.error)
        self._equipped = 0
        self._trace = trace
        if trace is not None:
            trace.attend(engine)

    def simulate(
        self,
        duration: float | None,
        progress: Callable[[Progress], None] | None,
        stop: Callable[[], bool] | None,
        writer: Writer | None,
    ) -> Results:
        if writer is not None:
            for name, rows in self._rows.items():
                rows.stream(partial(writer.put, name))
        begin, dt = self._session.begin, self._session.dt
        end = self._session.end if duration is None else begin + duration
        outcome, reason = "completed", ""
        while (end is None and not self._session.exhausted) or (end is not None and self._session.time < end - dt / 2):
            try:
                self._step()
            except SumoError as error:
                outcome, reason = "failed", str(error)
                break
            if progress is not None:
                progress(
                    Progress(
                        self._session.time - begin,
                        None if end is None else end - begin,
                        len(self._engine.traffic.present),
                        len(self._crashes),
                        len(self._interventions),
                    )
                )
            if stop is not None and stop():
                outcome = "interrupted"
                break
        return self._results(outcome, reason, writer)

    def end_forks(self) -> None:
        """Give up the other worlds that are still out: there are some when the run was left by an exception."""
        if self._verdicts is not None:
            self._verdicts.end_forks()

    def _step(self) -> None:
        """One walk through the house; the books are written when all is decided, and nothing of it done."""
        engine = self._engine
        engine.observe()
        time, wrecked = engine.time, engine.wrecks.wrecked
        self._book_comings_and_goings()
        for crash in engine.crashes:
            self._book_crash(crash)
        engine.decide()
        begun = [(slot, self._book_action(time, slot, target)) for slot, target in engine.acting]
        self._interventions.expire(time)
        self._conflicts.step(time, engine.leads, engine.paths.crossings, wrecked, engine.fleet.equipped)
        self._book.step(time, wrecked)
        if self._trace is not None:
            self._trace.step(time)
        if self._verdicts is not None:
            self._verdicts.step([(slot, new) for slot, new in begun if new is not None])
            self._interventions.flush()
        engine.act()

    def _book_comings_and_goings(self) -> None:
        t, fleet = self._engine.traffic, self._engine.fleet
        for slot, vehicle in t.left:
            self._interventions.close(vehicle, "left")
            if vehicle in t.arrived and vehicle not in self._engine.wrecks.removed:
                self._book.arrive(slot)
            else:
                self._book.remove(slot)
        self._crashes.reconcile(self._engine.wrecks.reported.keys(), {vehicle for _, vehicle in t.left})
        for slot in t.departed:
            system = fleet.system(slot)
            self._equipped += bool(system)
            self._book.depart(slot, system)

    def _book_crash(self, crash: Crash) -> None:
        hit = crash.impact
        self._crashes.book(crash)
        on_wheels = [slot for slot in (hit.striker, hit.struck) if self._engine.traffic.wheeled[slot]]
        self._book.crash(np.array(on_wheels), self._engine.time)
        self._conflicts.crash(hit.striker, hit.struck)
        self._interventions.close(crash.striker, "crash", hit.striker_speed)
        self._interventions.close(crash.struck, "crash", hit.struck_speed)

    def _book_action(self, time: float, slot: int, target: Target | None) -> Intervention | None:
        t, fleet = self._engine.traffic, self._engine.fleet
        vehicle = t.ids[slot]
        return self._interventions.act(
            time,
            vehicle,
            t.vclass[slot],
            Action(
                strategy=fleet.system(slot),
                phase=int(fleet.demand.phase[slot]),
                decel=float(fleet.decel[slot]) if t.speed[slot] > 0 else 0.0,
                speed=float(t.speed[slot]),
                target=t.ids[target.slot] if target else "",
                target_vclass=t.vclass[target.slot] if target else "",
                target_kind=("crossing" if target.crossing else "lead") if target else "",
                gap=target.gap if target else np.nan,
                ttc=target.ttc if target else np.nan,
                ttc2=target.ttc2 if target else np.nan,
                closing_speed=target.closing_speed if target else np.nan,
                error=self._engine.error(slot, target.slot if target else None),
                x=float(t.x[slot]),
                y=float(t.y[slot]),
                lane=partial(lane, vehicle),
            ),
        )

    @property
    def _rows(self) -> dict[str, Rows]:
        """Those that come while the run goes, by table."""
        return {
            "crashes": self._crashes.rows,
            "interventions": self._interventions.rows,
            "conflicts": self._conflicts.rows,
            "traffic": self._book.rows,
        }

    def _results(self, outcome: str, reason: str, writer: Writer | None) -> Results:
        session, engine = self._session, self._engine
        wrecks, audit = engine.wrecks, engine.override.audit
        self._interventions.close_all()
        if self._verdicts is not None:
            self._verdicts.finish("" if outcome == "completed" else f"the run was {outcome}")
            self._interventions.flush()
        self._conflicts.close_all()
        self._book.close_interval(session.time)
        self._crashes.reconcile(wrecks.reported.keys())
        run = {
            "scenario": self._scenario.name,
            "strategy": self._carried.name,
            "sensing": self._carried.sensing,
            "parameters": self._carried.parameters,
            "penetration": None if np.isnan(self._carried.penetration) else self._carried.penetration,
            "seed": session.seed,
            "drivers": self._scenario.drivers.name,
            "step_length_s": session.dt,
            "begin_s": session.begin,
            "end_s": session.time,
            "demand": self._scenario.scale * self._scenario.factor,
            "ebike_share": self._scenario.demand.ebike_share if self._scenario.demand else None,
            "weather": self._scenario.weather,
            "mu": self._scenario.mu,
            "blockage_s": self._blockage,
            "outcome": outcome,
            "reason": reason,
            "vehicles": engine.traffic.inserted,
            "equipped": self._equipped,
            "crashes": len(self._crashes),
            "sumo_collisions": len(wrecks.reported),
            "confirmed_by_sumo": self._crashes.confirmed,
            "sumo_only": len(wrecks.reported) - self._crashes.confirmed,
            "contacts_dismissed": len(wrecks.dismissed),
            "override_commands": audit.commands,
            "override_violations": audit.violations,
            "override_worst_mps": audit.worst,
            "teleports": engine.traffic.teleports,
            "aeb_sumo_version": aeb_sumo.__version__,
            "sumo_version": session.version,
        }
        exposure = Rows("exposure")
        if writer is not None:
            exposure.stream(partial(writer.put, "exposure"))
        for row in self._book.exposure():
            exposure.append(row)
        books = self._rows | {"exposure": exposure}
        tables = {name: rows.of_run(self._run_id) for name, rows in books.items()}
        if writer is not None:
            writer.commit(run)
        return Results.of(tables | {"runs": [{"run_id": self._run_id} | run]})
