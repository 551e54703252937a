"""What each equipped vehicle reacts to: candidates from the world, tracked by its sensors, one target chosen."""

from dataclasses import dataclass

import numpy as np

from aeb_sumo.drivers.streams import number
from aeb_sumo.perception.crossing import Approach, conflicting
from aeb_sumo.perception.lead import sees_lead
from aeb_sumo.perception.noise import Keys
from aeb_sumo.perception.sensor import covered, overlap
from aeb_sumo.perception.suites import Suite
from aeb_sumo.perception.tracking import Measurable, Tracks, track_init, track_step
from aeb_sumo.soa import Bools, Floats, Ints, put, take
from aeb_sumo.strategies.base import Gaze
from aeb_sumo.world.observe import Traffic, VClasses
from aeb_sumo.world.paths import Paths
from aeb_sumo.world.surroundings import Leads, lateral_position

__all__ = ["Lookout", "Targets"]

_NO_CONFLICT = -np.inf
_NEAR_MISS = 6.0  # m, who will pass ahead at a greater lateral distance is no candidate, our assumption


@dataclass(frozen=True)
class Targets:
    """What each equipped vehicle reacts to, (n,) each, as its sensors tell it; see `Percept`.

    Attributes:
        slot: of the target, -1 for none.
        crossing: it crosses the own path.
    """

    slot: Ints
    crossing: Bools
    gap: Floats
    speed: Floats
    accel: Floats
    ahead: Floats
    left: Floats
    closing_ahead: Floats
    closing_left: Floats
    vulnerable: Bools

    @classmethod
    def none(cls, n: int) -> "Targets":
        """Nothing to react to, for `n` vehicles."""
        return cls(
            slot=np.full(n, -1, np.int64),
            crossing=np.zeros(n, np.bool_),
            gap=np.full(n, np.inf),
            speed=np.zeros(n),
            accel=np.zeros(n),
            ahead=np.full(n, np.inf),
            left=np.zeros(n),
            closing_ahead=np.zeros(n),
            closing_left=np.zeros(n),
            vulnerable=np.zeros(n, np.bool_),
        )


@dataclass(frozen=True)
class _Pairs:
    """Candidates: an equipped vehicle and another, (k,) each.

    Attributes:
        ego, other: slots.
        crossing: the other is on a path that crosses the own one.
        gap: to the other along the own path, or to where the paths cross [m].
        in_view: the geometry lets a sensor see it.
        zone: (k, 4) from the front bumpers to the crossing: own from and to, other's from and to [m].
    """

    ego: Ints
    other: Ints
    crossing: Bools
    gap: Floats
    in_view: Bools
    zone: Floats


class Lookout:
    """The eyes of all equipped vehicles: follows candidates from step to step.

    Leads are those that SUMO names, if they are where a sensor could see them. At junctions every pair of vehicles is
    a candidate whose planned paths cross (`Gaze.PATH`) or, for systems that know no paths, every pair there is.
    Whether two will meet at a crossing is judged on their true motion; sensing decides whether and where they are seen.
    """

    def __init__(
        self, traffic: Traffic, leads: Leads, paths: Paths, suite: Suite, gaze: Gaze, *, sublane: bool, seed: int
    ) -> None:
        self._traffic = traffic
        self._leads = leads
        self._sublane = sublane
        self._paths = paths
        self._suite = suite
        self._gaze = gaze
        self._seed = seed
        self._serials: Ints = np.zeros(0, np.int64)  # of ego and other in one number, per track
        self._tracks = track_init(suite, np.zeros(0, np.uint64), traffic.dt)
        self._conflict: Floats = np.zeros(0)  # for how long each track has been in conflict [s], < 0: it is not

    def step(self, rows: Ints, *, braking: Bools, time: float) -> Targets:
        """The targets of the vehicles in slots `rows` (rising).

        Args:
            rows: slots of the equipped vehicles.
            braking: per slot, the AEB is braking.
            time: now [s].
        """
        pairs = self._candidates(rows[self._traffic.speed[rows] > 0])
        tracks, conflict = self._matched(pairs)
        truth = self._measurable(pairs)
        tracks = track_step(self._suite, tracks, truth, time=time, dt=self._traffic.dt)
        known = tracks.motion(self._suite, truth, self._traffic.dt)
        if self._gaze is Gaze.PATH:
            dangerous = self._in_conflict(pairs, braking[pairs.ego] & (conflict >= 0))
            conflict = np.where(dangerous, np.where(conflict < 0, 0.0, conflict + self._traffic.dt), _NO_CONFLICT)
            counts = np.where(pairs.crossing, conflict >= self._suite.persist - self._traffic.dt / 2, True)
            rank = pairs.gap
        else:
            nears = (known.distance > 0) & (known.closing > 0)
            rank = np.divide(known.distance, known.closing, out=np.full(len(conflict), np.inf), where=nears)
            miss = known.left - known.closing_left * np.where(np.isfinite(rank), rank, 0.0)
            counts = np.isfinite(rank) & (np.abs(miss) < _NEAR_MISS)
        self._tracks, self._conflict = tracks, conflict
        return self._chosen(rows, pairs, truth, known, rank, tracks.confirmed & counts)

    def _candidates(self, moving: Ints) -> _Pairs:
        t = self._traffic
        ego = moving[self._leads.lead[moving] >= 0]
        other, gap = self._leads.lead[ego], self._leads.gap[ego]
        view = sees_lead(
            self._suite.reach,
            self._suite.field_of_view,
            x=t.x[ego],
            y=t.y[ego],
            heading=t.heading[ego],
            gap=gap,
            rear_x=t.back_x[other],
            rear_y=t.back_y[other],
            lead_heading=t.heading[other],
        )
        crossing_ego, crossing_other, zone = self._at_junctions(moving)
        crossing = np.zeros(len(ego) + len(crossing_ego), np.bool_)
        crossing[len(ego) :] = True
        crossing_view, distance = covered(
            self._suite.reach,
            self._suite.field_of_view,
            x=t.x[crossing_ego],
            y=t.y[crossing_ego],
            heading=t.heading[crossing_ego],
            target_x=(t.x + t.back_x)[crossing_other] / 2,
            target_y=(t.y + t.back_y)[crossing_other] / 2,
        )
        at = np.maximum(zone[:, 0], 0.0) if self._gaze is Gaze.PATH else distance
        return _Pairs(
            np.concatenate([ego, crossing_ego]),
            np.concatenate([other, crossing_other]),
            crossing,
            np.concatenate([gap, at]),
            np.concatenate([view, crossing_view]),
            np.vstack([np.full((len(ego), 4), np.nan), zone]),
        )

    def _at_junctions(self, moving: Ints) -> tuple[Ints, Ints, Floats]:
        """Pairs at junctions: egos, others, (k, 4) distances to where their paths cross, nan where they do not."""
        crossings = self._paths.crossings
        egos = np.zeros(self._traffic.capacity, np.bool_)
        egos[moving] = True
        to_come = egos[crossings.ego] & (crossings.zone[:, 1] > 0)
        ego, other, zone = crossings.ego[to_come], crossings.other[to_come], crossings.zone[to_come]
        if self._gaze is Gaze.PATH:
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

    def _matched(self, pairs: _Pairs) -> tuple[Tracks, Floats]:
        """Tracks and conflicts of the pairs, from the last step where they were candidates then."""
        t = self._traffic
        serials = t.serial[pairs.ego].astype(np.int64) * 2**32 + t.serial[pairs.other].astype(np.int64)
        serials = np.where(pairs.crossing, -serials, serials)  # a lead may be crossing traffic as well
        order = np.argsort(self._serials)
        place = np.searchsorted(self._serials, serials, sorter=order)
        at = order[np.minimum(place, len(order) - 1)] if len(order) else np.zeros(len(serials), np.int64)
        known = (self._serials[at] == serials) if len(order) else np.zeros(len(serials), np.bool_)
        tracks = track_init(self._suite, self._keys(pairs, ~known), t.dt)
        conflict = np.full(len(serials), _NO_CONFLICT)
        put(tracks, known, take(self._tracks, at[known]))
        conflict[known] = self._conflict[at[known]]
        self._serials = serials
        return tracks, conflict

    def _keys(self, pairs: _Pairs, new: Bools) -> Keys:
        """Identities of new pairs, for the noise of their tracks; an ideal suite has none."""
        keys = np.zeros(len(new), np.uint64)
        if self._suite.sensors:
            ids = self._traffic.ids
            for k in np.flatnonzero(new).tolist():
                keys[k] = number(self._seed, "sensor", ids[pairs.ego[k]], ids[pairs.other[k]])
        return keys

    def _measurable(self, pairs: _Pairs) -> Measurable:
        """The truth about the pairs, in the frame of the own front bumper."""
        t, ego, other = self._traffic, pairs.ego, pairs.other
        own_cos, own_sin = np.cos(t.heading[ego]), np.sin(t.heading[ego])
        turned = t.heading[other] - t.heading[ego]
        # A lead is measured at its rear, crossing traffic at its middle.
        share = np.where(pairs.crossing, 0.5, 1.0)
        dx = t.x[other] - share * t.length[other] * np.cos(t.heading[other]) - t.x[ego]
        dy = t.y[other] - share * t.length[other] * np.sin(t.heading[other]) - t.y[ego]
        ahead, left = dx * own_cos + dy * own_sin, dy * own_cos - dx * own_sin
        # The part of a lead's rear that is nearest to the own axis is seen.
        aside = np.where(pairs.crossing, np.abs(left), np.maximum(np.abs(left) - t.width[other] / 2, 0.0))
        along = np.cos(turned)
        return Measurable(
            in_view=pairs.in_view,
            distance=np.where(pairs.crossing, ahead, pairs.gap),
            closing=t.speed[ego] - t.speed[other] * along,
            closing_accel=t.accel[ego] - t.accel[other] * along,
            left=left,
            closing_left=-t.speed[other] * np.sin(turned),
            bearing=np.arctan2(aside, ahead),
            overlap=self._overlap(pairs),
            own_accel=t.accel[ego],
            turn=np.where(pairs.crossing, t.heading[ego] - t.old_heading[ego], 0.0),
        )

    def _overlap(self, pairs: _Pairs) -> Floats:
        """Share of the target's width in the own one, across the lane and not straight ahead: curves do not count.

        Without SUMO's sublane model all drive in the middle; crossing traffic shows its whole side.
        """
        share = np.ones(len(pairs.ego))
        leads = np.flatnonzero(~pairs.crossing)
        if self._sublane and len(leads):
            t, ego, other = self._traffic, pairs.ego[leads], pairs.other[leads]
            aside = lateral_position(t, other) - lateral_position(t, ego)
            share[leads] = overlap(left=aside, width=t.width[ego], target_width=t.width[other])
        return share

    def _in_conflict(self, pairs: _Pairs, locked: Bools) -> Bools:
        """Crossing traffic in view that would be at the crossing at the same time."""
        t, result = self._traffic, np.zeros(len(pairs.ego), np.bool_)
        k = np.flatnonzero(pairs.crossing & pairs.in_view)
        if not len(k):
            return result
        ego, other = pairs.ego[k], pairs.other[k]
        to_zone, through_zone, other_to_zone, other_through_zone = pairs.zone[k].T
        result[k] = conflicting(
            Approach(
                to_zone=to_zone,
                through_zone=through_zone,
                speed=t.speed[ego],
                length=t.length[ego],
                other_to_zone=other_to_zone,
                other_through_zone=other_through_zone,
                other_speed=t.speed[other],
                other_accel=t.accel[other],
                other_length=t.length[other],
                locked=locked[k],
            )
        )
        return result

    def _chosen(
        self, rows: Ints, pairs: _Pairs, truth: Measurable, known: Measurable, rank: Floats, usable: Bools
    ) -> Targets:
        """For each vehicle the usable candidate of the lowest rank; a lead before a crossing one of the same."""
        t, targets = self._traffic, Targets.none(len(rows))
        k = np.flatnonzero(usable)
        k = k[np.lexsort((pairs.crossing[k], rank[k], pairs.ego[k]))]
        k = k[np.unique(pairs.ego[k], return_index=True)[1]]
        ego, other = pairs.ego[k], pairs.other[k]
        # Only a system that knows paths waits for crossing traffic at the crossing, where it stands in the way.
        waits = pairs.crossing[k] & (self._gaze is Gaze.PATH)
        error = known.distance[k] - truth.distance[k]
        vulnerable = np.array([t.vclass[slot] in VClasses.RIDERS for slot in other.tolist()], np.bool_)
        ahead = known.distance[k]
        put(
            targets,
            np.searchsorted(rows, ego),
            Targets(
                slot=other,
                crossing=pairs.crossing[k],
                gap=np.where(waits, np.maximum(pairs.gap[k] + error, 0.0), ahead),
                speed=np.where(waits, 0.0, t.speed[ego] - known.closing[k]),
                accel=np.where(waits, 0.0, t.accel[ego] - known.closing_accel[k]),
                ahead=ahead,
                left=known.left[k],
                closing_ahead=known.closing[k],
                closing_left=known.closing_left[k],
                vulnerable=vulnerable,
            ),
        )
        return targets
