"""Who an equipped vehicle may have to react to: pairs of it and another, from leads and from paths that cross."""

from dataclasses import dataclass

import numpy as np

from aeb_sumo.perception.lead import sees_lead
from aeb_sumo.perception.sensor import covered
from aeb_sumo.perception.suites import Suite
from aeb_sumo.soa import Bools, Floats, Ints, joined
from aeb_sumo.strategies.base import Gaze
from aeb_sumo.world.footpaths import Footpaths
from aeb_sumo.world.leads import CLOSE, Leads
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.paths import Paths
from aeb_sumo.world.sightlines import Sightlines

__all__ = ["Candidates", "Pairs"]


@dataclass(frozen=True)
class Pairs:
    """An equipped vehicle and another, (k,) each.

    Attributes:
        ego, other: slots.
        crossing: the other is on a path that crosses the own one.
        gap: to the other along the own path, or to where the paths cross [m].
        in_view: within range and field of view, and nothing hides it.
        candidate: it may be a target now; else it was one a moment ago, and the sensors only go on watching it.
        zone: (k, 4) from the front bumpers to the crossing: own from and to, other's from and to [m]; nan if unknown.
    """

    ego: Ints
    other: Ints
    crossing: Bools
    gap: Floats
    in_view: Bools
    candidate: Bools
    zone: Floats


class Candidates:
    """Finds the pairs of a step.

    Leads are those that SUMO names with whom a conflict is possible (`aeb_sumo.world.leads`), if they are where a
    sensor could see them. Nothing but thin air is between a vehicle and the next one on its path, so lines of sight are
    asked only for crossing traffic. At junctions every pair of vehicles is a candidate whose planned paths cross
    (`Gaze.PATH`) or, for systems that know no paths, every pair there is (`Gaze.RELATIVE_MOTION`); so are, anywhere,
    persons on foot whose path meets the own one, or who are near. Systems for car-following have no eyes for any of
    these (`Gaze.LEAD`).
    """

    def __init__(
        self,
        traffic: Traffic,
        leads: Leads,
        paths: Paths,
        footpaths: Footpaths,
        sightlines: Sightlines,
        suite: Suite,
        gaze: Gaze,
    ) -> None:
        self._traffic = traffic
        self._leads = leads
        self._paths = paths
        self._footpaths = footpaths
        self._sightlines = sightlines
        self._suite = suite
        self._gaze = gaze
        self._last: Floats = np.zeros(0)  # numbers of the crossing pairs of the last step

    def of(self, egos: Ints) -> Pairs:
        """All pairs of the vehicles in these slots."""
        ego = egos[self._leads.watched[egos]]
        pairs = self._ahead(ego, self._leads.target[ego], self._leads.target_gap[ego])
        if self._gaze.sees_crossing:
            ego, other, zone = self._at_junctions(egos)
            if len(ego):
                pairs = joined(pairs, self._crossing(ego, other, zone))
            if len(self._traffic.walkers):
                pairs = joined(pairs, self._crossing(*self._on_foot(egos)))
        return pairs

    def known(self, pairs: Pairs) -> Bools:
        """(k,) whether sensors have followed the other for a while: a lead that the search before had found, too."""
        found = self._leads.known[pairs.ego] & (self._leads.lead[pairs.ego] == pairs.other)
        result: Bools = ~pairs.crossing & pairs.candidate & found
        return result

    def again(self, ego: Ints, other: Ints, crossing: Bools) -> Pairs:
        """Pairs that are not candidates any more, as the sensors see them now."""
        ahead, aside = (~crossing).nonzero()[0], crossing.nonzero()[0]
        lead, t = other[ahead], self._traffic
        t.follow(np.concatenate([ego, other]))
        rear_x, rear_y = t.rear(lead)
        straight = np.hypot(rear_x - t.x[ego[ahead]], rear_y - t.y[ego[ahead]])
        pairs = self._ahead(ego[ahead], lead, straight)
        if len(aside):
            nowhere = np.full((len(aside), 4), np.nan)
            pairs = joined(pairs, self._crossing(ego[aside], other[aside], nowhere))
        pairs.candidate[:] = False
        return pairs

    def _ahead(self, ego: Ints, other: Ints, gap: Floats) -> Pairs:
        t, n = self._traffic, len(ego)
        view = sees_lead(
            self._suite.reach,
            self._suite.field_of_view,
            ego=ego,
            lead=other,
            gap=gap,
            x=t.x,
            y=t.y,
            heading=t.heading,
            length=t.length,
        )
        return Pairs(ego, other, np.zeros(n, np.bool_), gap, view, np.ones(n, np.bool_), np.full((n, 4), np.nan))

    def _crossing(self, ego: Ints, other: Ints, zone: Floats) -> Pairs:
        t, n = self._traffic, len(ego)
        rear_x, rear_y = t.rear(other)
        view, distance = covered(
            self._suite.reach,
            self._suite.field_of_view,
            x=t.x[ego],
            y=t.y[ego],
            heading=t.heading[ego],
            target_x=(t.x[other] + rear_x) / 2,
            target_y=(t.y[other] + rear_y) / 2,
        )
        view[view] = self._sightlines.visible(ego[view], other[view])
        gap = np.maximum(zone[:, 0], 0.0) if self._gaze is Gaze.PATH else distance
        return Pairs(ego, other, np.ones(n, np.bool_), gap, view, np.ones(n, np.bool_), zone)

    def _on_foot(self, egos: Ints) -> tuple[Ints, Ints, Floats]:
        """The same for persons on foot, anywhere."""
        ego, other, zone = self._footpaths.crossings(egos)
        met = np.isfinite(zone[:, 0]) | (self._gaze is not Gaze.PATH)
        return ego[met], other[met], zone[met]

    def _numbers(self, ego: Ints, other: Ints) -> Floats:
        """(k,) one number per pair, which tells it from all others of a run with less than 2^26 vehicles."""
        return self._traffic.serial[ego] * 2.0**26 + self._traffic.serial[other]

    def _at_junctions(self, moving: Ints) -> tuple[Ints, Ints, Floats]:
        """Pairs at junctions: egos, others, (k, 4) distances to where their paths cross, nan where they do not."""
        crossings = self._paths.crossings
        if self._gaze is Gaze.PATH and not len(crossings.ego):
            self._last = self._last[:0]
            return crossings.ego, crossings.other, crossings.zone
        egos = np.zeros(self._traffic.capacity, np.bool_)
        egos[moving] = True
        to_come = egos[crossings.ego] & (crossings.zone[:, 1] > 0)
        if self._gaze is Gaze.PATH:  # it waits for others where the paths cross: farther away than that it never acts
            ego = crossings.ego
            near = crossings.zone[:, 0] <= self._traffic.speed[ego] * self._leads.horizon[ego] + CLOSE
            kept = (to_come & ~near & self._leads.at_work[ego]).nonzero()[0]
            if len(kept):  # those it brakes for do not get lost as it slows down: see `Leads`
                near[kept] = np.isin(self._numbers(ego[kept], crossings.other[kept]), self._last)
            to_come &= near
        ego, other, zone = crossings.ego[to_come], crossings.other[to_come], crossings.zone[to_come]
        if self._gaze is Gaze.PATH:
            self._last = self._numbers(ego, other)
            return ego, other, zone
        # Who knows no paths has to look at everyone there, but those on his own.
        turns, users = self._paths.turns, self._paths.users
        i, j = self._paths.pairs()
        path = np.array([id(users[u][0]) for u in turns.user.tolist()], np.int64)
        i, j = (k[egos[turns.slot[i]] & (path[i] != path[j])] for k in (i, j))
        size = self._traffic.capacity
        rest = ~np.isin(turns.slot[i] * size + turns.slot[j], ego * size + other)
        i, j = turns.slot[i[rest]], turns.slot[j[rest]]
        return (
            np.concatenate([ego, i]),
            np.concatenate([other, j]),
            np.concatenate([zone, np.full((len(i), 4), np.nan)]),
        )
