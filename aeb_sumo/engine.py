"""One world and all who act in it, a step at a time: observe -> perception -> strategy -> brake -> override."""

import numpy as np

from aeb_sumo.equipment import Equipment, System
from aeb_sumo.fleet import Fleet, Target
from aeb_sumo.fleets import Fleets
from aeb_sumo.motorists import Motorists
from aeb_sumo.scenarios import Scenario
from aeb_sumo.world.buildings import walls
from aeb_sumo.world.footpaths import Footpaths
from aeb_sumo.world.friction import Friction
from aeb_sumo.world.leads import Leads
from aeb_sumo.world.network import Network
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.override import Override
from aeb_sumo.world.paths import Paths
from aeb_sumo.world.session import Session
from aeb_sumo.world.sightlines import Sightlines
from aeb_sumo.world.violations import Violations
from aeb_sumo.world.walkers import Walkers
from aeb_sumo.world.wrecks import Crash, Wrecks

__all__ = ["Engine"]

_HORIZON = 5.0  # s, our assumption: longer than the TTC of 4 s from which conflicts are booked, and drivers' looming
_NEAR = 0.5  # m, our assumption: by so much SUMO's gaps may differ from the distance of the bodies
_BEFORE = 1.0  # s before a system may act from which it watches its target, our assumption: sensors take time, too


class Engine:
    """A running world: SUMO's traffic, drivers who err, and AEBs.

    One step is `observe`, `decide`, `act`. Between `decide` and `act` all is known of the present and nothing of the
    coming step has begun: this is where the books are written, and where the world can be forked.

    Args:
        session: SUMO, started.
        scenario: what it simulates.
        carried: who has which AEB.
        blockage: how long wrecks stand [s].
        every: read every vehicle in every step, and not only those that matter: slow, and the same.

    Attributes:
        traffic, leads, paths, friction, motorists, fleet, wrecks, override: the parts that can be looked at.
        time: of the state last observed [s].
        crashes: of the step that ended then.
        acting: slots whose AEB warns or brakes in the coming step, with their targets.
    """

    def __init__(
        self, session: Session, scenario: Scenario, carried: Equipment, blockage: float, *, every: bool = False
    ) -> None:
        self.session = session
        self._carried = carried
        network = Network()
        self.traffic = Traffic(session.dt, every=every)
        self.friction = Friction(self.traffic, scenario.mu, scenario.stretches)
        self.override = Override(self.traffic, self.friction)
        self.wrecks = Wrecks(self.traffic, network, session.sublane, blockage)
        systems = carried.systems or (System.of("none"),)
        slippery = min((scenario.mu, *(stretch.mu for stretch in scenario.stretches)))
        self._horizons = {s.name: s.strategy.longest_ttc(slippery) + _BEFORE for s in systems}
        self.leads = Leads(self.traffic, cycle=min(s.suite.search for s in systems), horizon=_HORIZON)
        self.paths = Paths(self.traffic, network)
        self._walkers = Walkers(self.traffic, network)
        self._sightlines = Sightlines(self.traffic, walls())
        drivers = scenario.drivers
        self.motorists = Motorists(self.traffic, self.leads, drivers, session.seed)
        self._violations = Violations(
            self.traffic, self.paths, drivers.failure_to_yield, drivers.riders, self._sightlines, session.seed
        )
        footpaths = Footpaths(self.traffic, self.paths, self._walkers)
        world = self.traffic, self.leads, self.paths, footpaths, self._sightlines, self.friction
        self.fleet = Fleets(
            {s.name: Fleet(*world, s.strategy, s.suite, sublane=session.sublane, seed=session.seed) for s in systems}
        )
        self.time = session.begin
        self.crashes: list[Crash] = []
        self.acting: list[tuple[int, Target | None]] = []

    def observe(self) -> None:
        """Let SUMO simulate one step, and see what has become of it: who came and went, and who crashed.

        Raises:
            SumoError: SUMO gave up.
        """
        t, fleet = self.traffic, self.fleet
        self.session.step()
        self.time = self.session.time
        t.observe()
        self._walkers.observe()
        fleet.fit()
        self._sightlines.step()
        self.override.verify()
        for slot, _ in t.left:
            fleet.leave(slot)
            self.motorists.leave(slot)
        for slot in t.departed:
            system = self._carried.of(t.ids[slot], vtype=t.vtype[slot], vclass=t.vclass[slot], seed=self.session.seed)
            self.equip(slot, system.name if system else "")
            self.motorists.depart(slot, t.ids[slot], self.time)
        self.leads.step(self.fleet.at_work, np.append(self.override.braking, self.wrecks.sliding))
        self.paths.step()
        self._follow()
        self.crashes = self.wrecks.step(self.time, apart=self._apart())

    def _apart(self) -> bool:
        """Whether nobody can have touched anybody: no one is near a crossing or on foot, and all gaps are wide.

        A gap that is wider than what the lead has driven in the step was open all the time.
        """
        t, egos = self.traffic, self.leads.egos
        if len(self.paths.turns.slot) or len(t.walkers) or self.session.sublane:
            return False
        lead = self.leads.lead[egos]
        return bool((self.leads.gap[egos] > np.maximum(t.speed[lead], t.old_speed[lead]) * t.dt + _NEAR).all())

    def _follow(self) -> None:
        """Keep an eye on all who take part in what may happen; those near junctions are followed already."""
        t, egos = self.traffic, self.leads.watched.nonzero()[0]
        if len(t.walkers):  # they may be anywhere
            t.follow(t.present)
            return
        several = [egos, self.leads.target[egos], self.fleet.busy, self.override.braking, self.motorists.startling]
        slots = np.concatenate([each for each in several if len(each)] or [egos])
        if len(slots):
            t.follow(slots[t.here[slots]])

    def decide(self) -> None:
        """What drivers and AEBs do in the coming step."""
        t, wrecked = self.traffic, self.wrecks.wrecked
        self.motorists.step(self.time, self.fleet.decel, wrecked)
        self._violations.step(self.motorists.attentive)
        self.fleet.step(self.time, wrecked)
        self.acting = self.fleet.active()
        warnings = [(t.ids[slot], t.ids[target.slot]) for slot, target in self.acting if target is not None]
        self.motorists.hear(self.next_time, warnings)

    def act(self) -> None:
        """Command what has been decided; the last thing in a step."""
        self.override.drive(
            erring=self.motorists.erring,
            erring_accel=self.motorists.accel,
            aeb=self.fleet.decel,
            wrecked=self.wrecks.wrecked,
            wreck_speed=self.wrecks.speed,
        )
        self.wrecks.clear(self.time)
        self.traffic.release_slots()

    @property
    def heeded(self) -> set[int]:
        """Slots of drivers who do, from the coming step on, something else because of a warning; it may name others."""
        return self.motorists.heeded | self._violations.heeded

    @property
    def next_time(self) -> float:
        """End of the coming step [s]."""
        return round(self.time + self.traffic.dt, 3)  # as `Session.time` has it

    def error(self, slot: int, other: int | None = None) -> str:
        """The error that a road user makes now, by name; towards another, if named."""
        return self._violations.error(slot, other) or self.motorists.error(slot)

    def equip(self, slot: int, system: str) -> None:
        """Give the vehicle in a slot an AEB system, by name; the run must know it, if only with a share of 0."""
        self.leads.watch(slot, max(_HORIZON, self._horizons.get(system, 0.0)))
        self.fleet.leave(slot)
        self.fleet.depart(slot, system, self.time)

    def suppress(self, slot: int, span: tuple[float, float] | None = None) -> None:
        """Take back what the AEB in a slot has decided, and all it does until it has been quiet for a while.

        The intervention that is under way then does not take place; those before and after it do.

        Args:
            slot: of the vehicle.
            span: when the intervention began, and when it last acted [s]; None for now.
        """
        span = (self.time, self.time) if span is None else span
        self.fleet.withhold(slot, self.time, span[1])
        self.motorists.unwarned(slot, span)
        self.acting = [one for one in self.acting if one[0] != slot]
