"""All drivers: who does something else than SUMO's driver would, and what.

A driver is SUMO's own until he looks away, brakes hard for no visible reason, or has to react to a vehicle ahead that
came as a surprise: because his eyes were elsewhere, or because it brakes harder than anyone expects. Until he has
noticed and reacted he goes on as he is, but does not speed up with his eyes on the road; then he brakes as his model
says, until nothing closes in any more.
"""

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np

from aeb_sumo.criticality import required_decel, ttc2
from aeb_sumo.drivers.lapses import Glances, Lapses
from aeb_sumo.drivers.profile import Profile
from aeb_sumo.drivers.reactions import Reaction, Response, Threat
from aeb_sumo.drivers.streams import stream
from aeb_sumo.soa import Bools, Floats, Ints, fitted
from aeb_sumo.world.kinds import VClasses
from aeb_sumo.world.leads import Leads
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.surroundings import Onward

__all__ = ["Motorists", "Notice"]

_SAME_WAY = 0.5  # cosine of 60 degrees, our assumption: SUMO also names leads on other lanes of a junction
_STRONGEST = 10.0  # 1/s, our assumption: nearer than this, the jerk is as good as infinite
_HARDEST = 10.0  # m/s2, our assumption: a vehicle that stops harder has been stopped by another


@dataclass(frozen=True)
class Notice:
    """A driver has noticed a threat: his slot, whether late, his delay [s] and the time to the crash then [s]."""

    slot: int
    late: bool
    delay: float
    time_to_crash: float


class _Alert(NamedTuple):
    """A warning on its way to a driver: of whom, when it reaches him and from when on it could be heard [s]."""

    target: str
    due: float
    given: float


@dataclass
class _Reacting:
    """A driver who reacts, or is yet to notice what to react to."""

    ahead: float  # serial number of the vehicle
    late: bool
    held: float  # acceleration until he brakes [m/s2]
    response: Response | None = None
    onset: float = np.inf
    jerk: float = 0.0


class Motorists:
    """Drivers' lapses and reactions.

    Attributes:
        erring: per slot, the driver does not do what SUMO's would.
        accel: per slot, what he does instead, signed [m/s2].
        away: per slot, his eyes are off the road.
        attentive: per slot, a warning keeps his eyes on the road.
        noticed: who noticed a threat in the last step.
        braked: slots of vehicles whose AEB braked in the last step.
        heeded: slots of drivers who do, from this step on, something else because of a warning; it may name others.
        startling: slots of vehicles that SUMO may at any time let brake so hard that it takes those behind by surprise.
    """

    def __init__(self, traffic: Traffic, leads: Leads, profile: Profile, seed: int) -> None:
        self._traffic, self._leads, self._profile, self._seed = traffic, leads, profile, seed
        self._lapses = Lapses((profile.hard_braking, profile.glances, profile.robots), seed)
        self._onward = Onward(traffic)
        self.startling: Ints = np.zeros(0, np.int64)
        self._reacting: dict[int, _Reacting] = {}
        self._alerts: dict[int, _Alert] = {}  # by slot
        self._until: dict[int, float] = {}  # slot -> attentive until [s]
        self._delay = None if profile.warned is None else lru_cache(partial(profile.warned.delay, seed))
        self.erring: Bools = np.zeros(0, np.bool_)
        self.accel: Floats = np.zeros(0)
        self.away: Bools = np.zeros(0, np.bool_)
        self.attentive: Bools = np.zeros(0, np.bool_)
        self._surprise: Floats = np.zeros(0)
        self._held: Floats = np.zeros(0)
        models = (profile.cars, profile.trucks)
        self._least_surprise = min((model.surprise for model in models if model is not None), default=np.inf)
        self.noticed: list[Notice] = []
        self.heeded: set[int] = set()
        self.braked: set[int] = set()
        self._wrecked: Bools = np.zeros(0, np.bool_)

    def depart(self, slot: int, vehicle: str, time: float) -> None:
        """A vehicle enters."""
        self._fit()
        model = self._model(slot)
        self._surprise[slot] = np.inf if model is None else model.surprise
        if self._traffic.brakes[slot] > self._least_surprise:
            self.startling = np.append(self.startling, slot)
        self.away[slot] = self.attentive[slot] = False
        if self._traffic.driven[slot] or self._profile.robots is not None:
            self._lapses.depart(slot, vehicle, time)

    def leave(self, slot: int) -> None:
        """A vehicle is gone."""
        self.startling = self.startling[self.startling != slot]
        self._lapses.leave(slot)
        self._onward.forget(slot)
        self.away[slot] = self.attentive[slot] = False
        self._reacting.pop(slot, None)
        self._alerts.pop(slot, None)
        self._until.pop(slot, None)

    def hear(self, time: float, warnings: Iterable[tuple[str, str]]) -> None:
        """AEBs warn.

        Args:
            time: from when on it can be heard: the end of the coming step [s].
            warnings: vehicles whose AEB warns or brakes in it, and their targets.
        """
        if self._delay is None:
            return
        for vehicle, target in warnings:
            slot = self._traffic.slot[vehicle]
            known = self._alerts.get(slot, _Alert("", np.inf, np.inf))
            if target != known.target:
                alert = _Alert(target, time + self._delay(vehicle, target), time)
                self._alerts[slot] = alert if alert.due <= known.due else known._replace(target=target)

    def alerted(self, slot: int, span: tuple[float, float], *, by: float) -> bool:
        """Whether a warning of an AEB that acted in a span of time reaches the driver by then [s].

        One that has reached him is over.
        """
        return self._warned(slot, span) and self._alerts[slot].due <= by

    def unwarned(self, slot: int, span: tuple[float, float] = (-np.inf, np.inf)) -> None:
        """The warning on its way to the driver in a slot was never given, if it was given in a span of time [s]."""
        if self._warned(slot, span):
            del self._alerts[slot]

    def _warned(self, slot: int, span: tuple[float, float]) -> bool:
        """Whether a warning is on its way that was given in the steps that begin in that span of time."""
        alert = self._alerts.get(slot)
        return alert is not None and span[0] < alert.given < span[1] + 1.5 * self._traffic.dt

    def step(self, time: float, aeb: Floats, wrecked: Bools) -> None:
        """From the state just observed to what drivers do in the coming step.

        Args:
            time: now [s].
            aeb: per slot, deceleration by their AEBs' brakes in the last step [m/s2].
            wrecked: per slot.
        """
        self._fit()
        self.noticed, self.heeded = [], set()
        self.braked = set((aeb > 0).nonzero()[0].tolist())
        self._wrecked = wrecked.copy()  # as of this step: what a driver does when he crashes is his error
        self._lapses.advance(time)
        self._heed(time)
        self._read({*self._lapses.changed, *self._lapses.looked_away})
        self._glance()
        self._surprised(wrecked)
        self._react(time, wrecked)
        self.erring[:] = self.away
        self.accel[:] = self._held
        for slot, driver in self._reacting.items():
            self.erring[slot], self.accel[slot] = True, self._reaction(driver, time)
        for slot, kind in self._lapses.decisive.items():
            self.erring[slot], self.accel[slot] = True, self._lapses.accel[slot, kind]

    def error(self, slot: int) -> str:
        """What a driver does wrong now, by name, or empty."""
        if slot >= len(self._wrecked) or self._wrecked[slot]:
            return ""
        if slot in self._lapses.decisive:
            return self._lapses.kinds[self._lapses.decisive[slot]].name
        if slot in self._reacting:
            return Glances.name if self._reacting[slot].late else "surprised"
        return Glances.name if self.away[slot] else ""

    def _read(self, slots: set[int]) -> None:
        here = [slot for slot in slots if self._traffic.here[slot]]
        if here:
            self._traffic.read(np.array(here))

    def _look(self, slots: Collection[int]) -> None:
        """Drivers look at the vehicles ahead, now: it is no matter of searching."""
        if slots:
            self._read({*slots, *(self._leads.now(slot)[0] for slot in slots)} - {-1})

    def _warned_away(self) -> list[int]:
        """Slots of drivers whose eyes are off the road, and whom a warning calls back."""
        return [slot for slot in sorted(self._until) if self.away[slot]]

    def _model(self, slot: int) -> Reaction | None:
        return self._profile.trucks if self._traffic.vclass[slot] in VClasses.HEAVY else self._profile.cars

    def _heed(self, time: float) -> None:
        """Warnings reach drivers."""
        warned = self._profile.warned
        if warned is None:
            return
        for slot, alert in list(self._alerts.items()):
            if time >= alert.due:  # also when the warning has ended meanwhile
                self._until[slot] = time + warned.attention
                del self._alerts[slot]
        for slot, until in list(self._until.items()):
            self.attentive[slot] = until > time
            if until <= time:
                del self._until[slot]

    def _glance(self) -> None:
        t, calm = self._traffic, self._profile.glances
        if calm is None:
            return
        warned = self._warned_away()
        self.heeded.update(warned)
        back = [slot for slot in [*self._lapses.looked_back, *warned] if self.away[slot]]
        for slot in back:
            self.away[slot] = False
        # Where no conflict is possible there is nothing to react to.
        back = [slot for slot in back if self._leads.possible[slot]]
        self._look(back)
        for slot in back:
            self._look_back(slot)
        for slot in self._lapses.looked_away:
            # A short glance may have ended within the same step.
            busy = slot in self._reacting or not self._lapses.on[slot, self._lapses.glance]
            if busy or not t.here[slot] or self._demanding(slot, calm):
                continue
            if self.attentive[slot]:
                self.heeded.add(slot)
            else:
                self.away[slot] = True
                self._held[slot] = t.accel[slot]

    def _demanding(self, slot: int, calm: Glances) -> bool:
        """Whether the driver has reason to keep his eyes on the road just now.

        He has when he brakes or speeds up, closes in on the vehicle ahead, follows it closely, has not had it ahead for
        long, or has to find a gap because his lane soon leads off his route; `calm` says from where on. Drivers choose
        calm moments to look away.
        """
        t, leads = self._traffic, self._leads
        if abs(t.accel[slot]) > calm.calm_accel:
            return True
        gap, closing = leads.gap[slot], leads.rate[slot]
        if leads.lead[slot] >= 0 and not (gap >= closing * calm.calm_ttc and gap >= t.speed[slot] * calm.calm_headway):
            return True
        return self._onward.left(slot) < calm.calm_lane

    def _look_back(self, slot: int) -> None:
        """The eyes are on the road again: is there something to react to?"""
        lead, _ = self._leads.now(slot)
        if lead >= 0 and self._same_way(slot, lead) and self._sees(slot, lead):
            self._reacting[slot] = _Reacting(self._traffic.serial[lead], True, self._held[slot])

    def _surprised(self, wrecked: Bools) -> None:
        """Followers of those who brake harder than anyone expects."""
        t = self._traffic
        if self._least_surprise == np.inf:
            return
        braking = (t.accel < -self._least_surprise).nonzero()[0]
        braking = braking[(t.followed_at[braking] == t.step) & t.here[braking]]
        if not len(braking):
            return
        rows = self._leads.behind(braking)
        rows = rows[t.driven[rows] & ~self.away[rows] & ~wrecked[rows]]
        slots = [slot for slot in rows.tolist() if slot not in self._reacting]
        self._look(slots)
        for slot in slots:
            ahead, _ = self._leads.now(slot)
            if ahead >= 0 and t.accel[ahead] < -self._surprise[slot] and self._same_way(slot, ahead):
                # With his eyes on the road he does not speed up any more; the braking of his AEB is not his own.
                held = 0.0 if slot in self.braked else min(float(t.accel[slot]), 0.0)
                self._reacting[slot] = _Reacting(t.serial[ahead], False, held)

    def _react(self, time: float, wrecked: Bools) -> None:
        t = self._traffic
        self._look(self._reacting)
        for slot, driver in list(self._reacting.items()):
            lead, _ = self._leads.now(slot)
            if wrecked[slot] or lead < 0 or t.serial[lead] != driver.ahead or not self._same_way(slot, lead):
                del self._reacting[slot]
                continue
            closing = float(t.speed[slot] - t.speed[lead])
            calm = t.accel[lead] >= -self._surprise[slot]
            nothing = driver.response is None and not self._sees(slot, lead)
            if calm and (closing <= 0 or nothing):
                del self._reacting[slot]
                continue
            if driver.response is None and (self._sees(slot, lead) or self._heeds(slot)):
                if self._mild(slot, lead):
                    del self._reacting[slot]
                    continue
                self._notice(slot, lead, driver, closing, time)
            if driver.onset > time and self._heeds(slot):
                driver.onset = time
            if driver.response is not None and driver.jerk == 0 and time >= driver.onset:
                looming = min(self._looming(slot, lead), _STRONGEST)
                driver.jerk = driver.response.jerk + driver.response.jerk_per_looming * looming
                driver.onset = time

    def _heeds(self, slot: int) -> bool:
        """Whether a warning makes a driver do what he would not do without it."""
        if self.attentive[slot]:
            self.heeded.add(slot)
        return bool(self.attentive[slot])

    def _notice(self, slot: int, lead: int, driver: _Reacting, closing: float, time: float) -> None:
        t, model = self._traffic, self._model(slot)
        crash_in = self._time_to_crash(slot, lead, driver.held)
        if model is None or not np.isfinite(crash_in):
            return
        threat = Threat(time_to_crash=crash_in, closing_speed=max(closing, 0.0), late=driver.late)
        driver.response = model.respond(
            stream(self._seed, "driver", t.ids[slot]), stream(self._seed, "reaction", t.ids[slot], t.ids[lead]), threat
        )
        driver.onset = time + driver.response.delay
        self.noticed.append(Notice(slot, driver.late, driver.response.delay, crash_in))

    def _mild(self, slot: int, lead: int) -> bool:
        """Whether this is no emergency: the vehicle ahead does not brake hard, and little is needed."""
        t, model = self._traffic, self._model(slot)
        needed = required_decel(
            gap=self._leads.now(slot)[1], speed=t.speed[slot], lead_speed=t.speed[lead], lead_accel=t.accel[lead]
        )
        return model is not None and bool(t.accel[lead] >= -model.surprise and needed <= model.mild)

    def _reaction(self, driver: _Reacting, time: float) -> float:
        """Acceleration of one who reacts [m/s2]."""
        if driver.response is None or driver.jerk == 0 or time < driver.onset:
            return driver.held
        before = max(-driver.held, 0.0)
        return -max(before, min(driver.response.decel, before + driver.jerk * (time - driver.onset)))

    def _time_to_crash(self, slot: int, lead: int, held: float) -> float:
        """If both go on as they are [s]: a vehicle ahead that brakes to a stop stays where it is."""
        t, (_, gap) = self._traffic, self._leads.now(slot)
        speed, lead_speed = float(t.speed[slot]), float(t.speed[lead])
        braking = max(float(t.accel[lead]), -_HARDEST)
        first = float(ttc2(gap=gap, closing_speed=speed - lead_speed, closing_accel=held - braking))
        if braking >= 0 or first <= lead_speed / -braking:
            return first
        return float(ttc2(gap=gap + lead_speed**2 / (2 * -braking), closing_speed=speed, closing_accel=held))

    def _sees(self, slot: int, lead: int) -> bool:
        """Whether there is a threat that the driver notices when he looks."""
        model = self._model(slot)
        if model is None:
            return False
        lights = model.sees_brake_lights and self._traffic.accel[lead] < -model.surprise
        return bool(lights or self._looming(slot, lead) >= model.looming)

    def _looming(self, slot: int, lead: int) -> float:
        """Inverse time to collision [1/s], 0 when nothing closes in."""
        closing = float(self._traffic.speed[slot] - self._traffic.speed[lead])
        _, gap = self._leads.now(slot)
        return 0.0 if closing <= 0 else np.inf if gap <= 0 else closing / gap

    def _same_way(self, slot: int, lead: int) -> bool:
        return bool(np.cos(self._traffic.heading[slot] - self._traffic.heading[lead]) > _SAME_WAY)

    def _fit(self) -> None:
        n = self._traffic.capacity
        if len(self.erring) == n:
            return
        self._lapses.fit(n)
        for name in ("erring", "accel", "away", "attentive", "_surprise", "_held"):
            setattr(self, name, fitted(getattr(self, name), n))
