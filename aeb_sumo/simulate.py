"""One run, from a scenario to tables."""

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import aeb_sumo
from aeb_sumo import strategies
from aeb_sumo.drivers.errors import FailureToYield, Lapses
from aeb_sumo.drivers.streams import stream
from aeb_sumo.errors import InputError
from aeb_sumo.fleet import Fleet, Target
from aeb_sumo.ledger.interventions import Action, Interventions
from aeb_sumo.ledger.traffic import TrafficBook
from aeb_sumo.parameters import differences
from aeb_sumo.perception.suites import Suite, suite
from aeb_sumo.results import Results
from aeb_sumo.scenarios import Scenario
from aeb_sumo.soa import Bools, Floats, fitted
from aeb_sumo.strategies.base import Strategy
from aeb_sumo.trace import Trace
from aeb_sumo.world.friction import Friction
from aeb_sumo.world.network import Network
from aeb_sumo.world.observe import Traffic, VClasses
from aeb_sumo.world.override import Override
from aeb_sumo.world.paths import Paths
from aeb_sumo.world.session import IMPOSED, Session, SumoError, output_prefix
from aeb_sumo.world.surroundings import demanding
from aeb_sumo.world.wrecks import Crash, Wrecks
from aeb_sumo.world.yielding import Yielding

__all__ = ["Progress", "run"]

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
    strategy: str | Strategy = "zhao2025",
    *,
    penetration: float = 1.0,
    seed: int | None = None,
    duration: float | None = None,
    step_length: float | None = None,
    blockage: float | None = None,
    interval: float = 60.0,
    sensing: str | Suite | None = None,
    trace: Trace | None = None,
    sumo_output: Path | None = None,
    progress: Callable[[Progress], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> Results:
    """Simulate a scenario with an AEB fleet.

    Args:
        scenario: what is simulated.
        strategy: the AEB, or its name; "none" is the baseline.
        penetration: share of cars equipped, 0 to 1. A car that is equipped at one share is so at every larger one.
        seed: of SUMO and of the drivers; None for the scenario's.
        duration: [s]; None for the scenario's.
        step_length: [s]; None for the scenario's.
        blockage: how long crashed vehicles stand before they leave [s]; None for 60, our assumption, or for SUMO's
            time-to-teleport if that is shorter.
        interval: of the rows of table `traffic` [s].
        sensing: what the equipped vehicles see with, a suite or its name; None for the strategy's own.
        trace: records vehicles step by step.
        sumo_output: folder for the output files that the scenario itself asks of SUMO; None throws them away.
        progress: called after every step.
        stop: asked after every step; True ends the run, whose tables are then marked as interrupted.

    Returns:
        The five tables of `aeb_sumo.results.TABLES`, one run.

    Raises:
        InputError: an argument is out of range, strategy or suite are unknown, or SUMO refuses the scenario.
    """
    brain = strategies.load(strategy) if isinstance(strategy, str) else strategy
    eyes = sensing if isinstance(sensing, Suite) else suite(sensing or brain.sensing)
    if not 0 <= penetration <= 1:
        raise InputError(f"penetration must lie within 0..1, not {penetration:g}")
    for name, value in (("duration", duration), ("step length", step_length), ("interval", interval)):
        if value is not None and not 0 < value < np.inf:
            raise InputError(f"{name} must be a positive number of seconds, not {value:g}")
    if blockage is not None and not 0 <= blockage < np.inf:
        raise InputError(f"blockage must be 0 or more seconds, not {blockage:g}")
    step = scenario.step_length if step_length is None else step_length
    number = scenario.seed if seed is None else seed
    with tempfile.TemporaryDirectory() as nowhere:
        routes = Path(nowhere) / "vehicles.rou.xml"
        routes.write_text(scenario.vehicles, encoding="utf-8")
        options = [
            *scenario.sumo_options,
            *(("--route-files", str(routes)) if scenario.vehicles else ()),
            *IMPOSED,
            *(("--step-length", f"{step:g}") if step is not None else ()),
            *(("--seed", str(number)) if number is not None else ()),
            "--output-prefix",
            output_prefix(str(Path(sumo_output or nowhere).resolve()), scenario.output_prefix),
        ]
        with Session(options) as session:
            span = scenario.duration if duration is None else duration
            # SUMO would put a wreck that stands for too long elsewhere.
            limit = session.time_to_teleport
            if blockage is not None and blockage > limit:
                raise InputError(f"blockage {blockage:g} s is longer than SUMO's time-to-teleport of {limit:g} s")
            stand = min(_BLOCKAGE, limit) if blockage is None else blockage
            one = _Run(session, scenario, brain, penetration, stand, interval, eyes, trace)
            return one.simulate(span, progress, stop)


class _Run:
    """The parts of one run, and the order in which they work."""

    def __init__(
        self,
        session: Session,
        scenario: Scenario,
        strategy: Strategy,
        penetration: float,
        blockage: float,
        interval: float,
        eyes: Suite,
        trace: Trace | None,
    ) -> None:
        self._session, self._scenario, self._strategy = session, scenario, strategy
        self._penetration, self._blockage = penetration, blockage
        self._seed = session.seed
        network = Network()
        self._traffic = Traffic(session.dt)
        friction = Friction(self._traffic, scenario.mu, scenario.stretches)
        self._override = Override(self._traffic, friction)
        self._wrecks = Wrecks(self._traffic, network, session.sublane, blockage)
        self._paths = Paths(self._traffic, network)
        self._lapses = Lapses(scenario.errors, self._seed)
        self._yielding = Yielding(self._traffic, scenario.errors.failure_to_yield, self._seed)
        self._needs_paths = strategy.name != "none" or scenario.errors.failure_to_yield is not None
        self._fleet = Fleet(
            self._traffic, self._paths, friction, strategy, eyes, sublane=session.sublane, seed=self._seed
        )
        self._sensing = eyes.name
        self._trace = trace and trace.of(self._traffic, self._fleet, friction)
        self._interventions = Interventions()
        self._book = TrafficBook(self._traffic, session.begin, interval)
        self._crashes: list[dict[str, Any]] = []
        self._equipped = 0
        self._excused = np.zeros(0, np.bool_)

    def simulate(
        self, duration: float | None, progress: Callable[[Progress], None] | None, stop: Callable[[], bool] | None
    ) -> Results:
        begin, dt = self._session.begin, self._session.dt
        end = self._session.end if duration is None else begin + duration
        outcome, reason = "completed", ""
        while (end is None and not self._session.exhausted) or (end is not None and self._session.time < end - dt / 2):
            try:
                self._session.step()
            except SumoError as error:
                outcome, reason = "failed", str(error)
                break
            self._step()
            if progress is not None:
                progress(
                    Progress(
                        self._session.time - begin,
                        None if end is None else end - begin,
                        len(self._traffic.present),
                        len(self._crashes),
                        len(self._interventions.rows),
                    )
                )
            if stop is not None and stop():
                outcome = "interrupted"
                break
        return self._results(outcome, reason)

    def _step(self) -> None:
        """One walk through the house: observe -> perception -> strategy -> brake -> override -> books."""
        t, time = self._traffic, self._session.time
        t.observe()
        self._override.verify()
        self._lapses.fit(t.capacity)
        self._excused = fitted(self._excused, t.capacity)
        self._comings_and_goings(time)
        for crash in self._wrecks.step(time):
            self._book_crash(crash)
        wrecked = self._wrecks.wrecked

        turns = self._paths.near_junctions(t.present) if self._needs_paths else []
        erring, erring_accel = self._drivers(time)
        self._yielding.step(turns)
        self._fleet.step(time, turns, wrecked)
        self._override.drive(
            erring=erring,
            erring_accel=erring_accel,
            aeb=self._fleet.decel,
            wrecked=wrecked,
            wreck_speed=self._wrecks.speed,
        )
        for slot, target in self._fleet.active():
            self._book_action(time, slot, target)
        if self._trace is not None:
            self._trace.step(time)
        self._interventions.expire(time)
        self._book.step(time, wrecked)
        self._wrecks.clear(time)
        t.release_slots()

    def _comings_and_goings(self, time: float) -> None:
        t = self._traffic
        for slot, vehicle in t.left:
            self._fleet.leave(slot)
            self._lapses.leave(slot, vehicle)
            self._interventions.close(vehicle, "left")
            if vehicle in t.arrived and vehicle not in self._wrecks.removed:
                self._book.arrive(slot)
        for slot in t.departed:
            vehicle, vclass = t.ids[slot], t.vclass[slot]
            equipped = (
                self._strategy.name != "none"
                and vclass in VClasses.CARS
                and bool(stream(self._seed, "equip", vehicle).random() < self._penetration)
            )
            self._equipped += equipped
            self._fleet.depart(slot, equipped=equipped)
            self._book.depart(slot, equipped=equipped)
            if vclass in VClasses.DRIVEN or self._scenario.errors.robots is not None:
                self._lapses.depart(slot, vehicle, time)

    def _drivers(self, time: float) -> tuple[Bools, Floats]:
        """Per slot: the driver errs, and with what acceleration [m/s2].

        A glance that would begin in a demanding moment is left out, from its start to its end; its draw is not.
        """
        t = self._traffic
        self._lapses.advance(time)
        erring, accel, away = self._lapses.erring()
        self._excused &= away
        for slot in self._lapses.looked_away:
            self._excused[slot] = t.here[slot] and demanding(t, slot)
        return erring & ~self._excused, accel

    def _error(self, slot: int, other: int | None = None) -> str:
        """The error that a driver makes now, by name; towards another vehicle, if named."""
        t = self._traffic
        if other is not None and (t.ids[slot], t.ids[other]) in self._yielding.overlooked:
            return FailureToYield.name
        return "" if self._excused[slot] else self._lapses.name(slot)

    def _book_crash(self, crash: Crash) -> None:
        t, hit = self._traffic, crash.impact
        self._crashes.append(
            {
                "crash_id": len(self._crashes),
                "time_s": hit.time,
                "kind": crash.kind,
                "typology": crash.typology,
                "x_m": hit.x,
                "y_m": hit.y,
                "lane": crash.lane,
                "impact_speed_mps": hit.impact_speed,
                "angle_deg": float(np.degrees(hit.angle)),
                "secondary": crash.secondary,
                "striker": crash.striker,
                "struck": crash.struck,
                "striker_speed_mps": hit.striker_speed,
                "struck_speed_mps": hit.struck_speed,
                "striker_delta_v_mps": hit.striker_delta_v,
                "struck_delta_v_mps": hit.struck_delta_v,
                "striker_vclass": t.vclass[hit.striker],
                "struck_vclass": t.vclass[hit.struck],
                "striker_vtype": t.vtype[hit.striker],
                "struck_vtype": t.vtype[hit.struck],
                "striker_equipped": bool(self._fleet.equipped[hit.striker]),
                "struck_equipped": bool(self._fleet.equipped[hit.struck]),
                "striker_error": self._error(hit.striker, hit.struck),
                "struck_error": self._error(hit.struck, hit.striker),
                "striker_aeb_phase": int(self._fleet.demand.phase[hit.striker]),
            }
        )
        self._interventions.close(crash.striker, "crash", hit.striker_speed)
        self._interventions.close(crash.struck, "crash", hit.struck_speed)

    def _book_action(self, time: float, slot: int, target: Target | None) -> None:
        t, vehicle = self._traffic, self._traffic.ids[slot]
        self._interventions.act(
            time,
            vehicle,
            t.vclass[slot],
            Action(
                phase=int(self._fleet.demand.phase[slot]),
                decel=float(self._fleet.decel[slot]) if t.speed[slot] > 0 else 0.0,
                speed=float(t.speed[slot]),
                target=t.ids[target.slot] if target else "",
                target_vclass=t.vclass[target.slot] if target else "",
                target_kind=("crossing" if target.crossing else "lead") if target else "",
                gap=target.gap if target else np.nan,
                ttc=target.ttc if target else np.nan,
                ttc2=target.ttc2 if target else np.nan,
                closing_speed=target.closing_speed if target else np.nan,
                error=self._error(slot, target.slot if target else None),
                x=float(t.x[slot]),
                y=float(t.y[slot]),
            ),
        )

    def _results(self, outcome: str, reason: str) -> Results:
        session, wrecks, audit = self._session, self._wrecks, self._override.audit
        self._interventions.close_all()
        self._book.close_interval(session.time)
        pairs = {tuple(sorted((row["striker"], row["struck"]))) for row in self._crashes}
        for row in self._crashes:
            row["sumo_reported"] = tuple(sorted((row["striker"], row["struck"]))) in wrecks.reported
        name = Path(self._scenario.name).stem
        run_id = f"{name}-{self._strategy.name}-p{self._penetration:g}-s{self._seed}"
        runs = {
            "scenario": self._scenario.name,
            "strategy": self._strategy.name,
            "sensing": self._sensing if self._strategy.name != "none" else "",
            "parameters": differences(self._strategy),
            "penetration": float(self._penetration),
            "seed": self._seed,
            "errors": self._scenario.errors.names(),
            "step_length_s": session.dt,
            "begin_s": session.begin,
            "end_s": session.time,
            "demand": self._scenario.scale,
            "ebike_share": self._scenario.demand.ebike_share if self._scenario.demand else None,
            "weather": self._scenario.weather,
            "mu": self._scenario.mu,
            "blockage_s": self._blockage,
            "outcome": outcome,
            "reason": reason,
            "vehicles": self._traffic.inserted,
            "equipped": self._equipped,
            "crashes": len(self._crashes),
            "sumo_collisions": len(wrecks.reported),
            "confirmed_by_sumo": len(pairs & set(wrecks.reported)),
            "sumo_only": len(set(wrecks.reported) - pairs),
            "contacts_dismissed": len(wrecks.dismissed),
            "override_commands": audit.commands,
            "override_violations": audit.violations,
            "override_worst_mps": audit.worst,
            "teleports": self._traffic.teleports,
            "aeb_sumo_version": aeb_sumo.__version__,
            "sumo_version": session.version,
        }
        tables = {
            "runs": [runs],
            "crashes": self._crashes,
            "interventions": self._interventions.rows,
            "exposure": self._book.exposure(),
            "traffic": self._book.rows,
        }
        return Results.of({k: [{"run_id": run_id, **row} for row in rows] for k, rows in tables.items()})
