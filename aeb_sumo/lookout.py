"""What each equipped vehicle reacts to: candidates from the world, tracked by its sensors, one target chosen."""

from dataclasses import dataclass

import numpy as np

from aeb_sumo.candidates import Candidates, Pairs
from aeb_sumo.drivers.streams import number
from aeb_sumo.perception.crossing import Approach, conflicting
from aeb_sumo.perception.noise import Keys
from aeb_sumo.perception.sensor import overlap
from aeb_sumo.perception.suites import Suite
from aeb_sumo.perception.tracking import Measurable, Tracks, track_init, track_settled, track_step
from aeb_sumo.soa import Bools, Floats, Ints, find, first_of_each, joined, mask, put, take
from aeb_sumo.strategies.base import Gaze
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.surroundings import lateral_position

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


class Lookout:
    """The eyes of all equipped vehicles: follows candidates from step to step.

    Sensing decides who is seen and where; whether two will meet at a crossing is judged on what is sensed of the
    other's motion, and on the paths that both are expected to take.
    """

    def __init__(
        self, traffic: Traffic, candidates: Candidates, suite: Suite, gaze: Gaze, *, sublane: bool, seed: int
    ) -> None:
        self._traffic = traffic
        self._candidates = candidates
        self._sublane = sublane
        self._suite = suite
        self._gaze = gaze
        self._seed = seed
        # Of the last step, per pair; and for how long it has not been a candidate, and been in conflict [s], < 0: not.
        none = np.zeros(0, np.int64)
        self._pairs = candidates.again(none, none, np.zeros(0, np.bool_))
        self._serials: Ints = none  # of ego and other in one number
        self._tracks = track_init(suite, np.zeros(0, np.uint64), traffic.dt)
        self._absent: Floats = np.zeros(0)
        self._conflict: Floats = np.zeros(0)

    @property
    def remembers(self) -> bool:
        """Whether there was anybody in the last step."""
        return len(self._serials) > 0

    def step(self, rows: Ints, *, braking: Bools, time: float) -> tuple[Ints, Targets]:
        """Those of the vehicles in slots `rows` (rising) that have a target: their slots, rising, and their targets.

        Args:
            rows: slots of the equipped vehicles.
            braking: per slot, the AEB is braking.
            time: now [s].
        """
        pairs = self._candidates.of(rows[self._traffic.speed[rows] > 0])
        pairs, tracks, conflict, new = self._followed(pairs, rows)
        truth = self._measurable(pairs)
        if new.any():
            # They are new to the tracker here, which leaves out who is no danger; not to that of the car.
            old = new & self._candidates.known(pairs)
            put(tracks, old, track_settled(self._suite, tracks.key[old], take(truth, old), self._traffic.dt))
        tracks = track_step(self._suite, tracks, truth, time=time, dt=self._traffic.dt)
        known = tracks.motion(self._suite, truth, self._traffic.dt)
        if self._gaze is Gaze.RELATIVE_MOTION:
            nears = (known.distance > 0) & (known.closing > 0)
            rank = np.divide(known.distance, known.closing, out=np.full(len(conflict), np.inf), where=nears)
            miss = known.left - known.closing_left * np.where(np.isfinite(rank), rank, 0.0)
            counts = np.isfinite(rank) & (np.abs(miss) < _NEAR_MISS)
        else:
            judged = pairs.crossing & pairs.candidate
            if judged.any():
                dangerous = judged & tracks.watched(self._suite)
                locked = braking[pairs.ego] & (conflict >= 0)
                dangerous[dangerous] = self._in_conflict(pairs, truth, known, locked, dangerous.nonzero()[0])
                conflict = np.where(judged, self._lasting(conflict, dangerous), conflict)
            counts = ~pairs.crossing | (conflict >= self._suite.persist - self._traffic.dt / 2)
            rank = pairs.gap
        self._pairs, self._tracks, self._conflict = pairs, tracks, conflict
        return self._chosen(pairs, truth, known, rank, tracks.confirmed & counts & pairs.candidate)

    def _numbers(self, pairs: Pairs) -> Ints:
        """One number per pair, which tells it from all others of the run."""
        t = self._traffic
        serials = t.serial[pairs.ego].astype(np.int64) * 2**32 + t.serial[pairs.other].astype(np.int64)
        return np.where(pairs.crossing, -serials, serials)  # a lead may be crossing traffic as well

    def _followed(self, pairs: Pairs, rows: Ints) -> tuple[Pairs, Tracks, Floats, Bools]:
        """Pairs with their tracks and conflicts from the last step, where they were there then, and who was not.

        Added to them are those that were candidates a moment ago: a track does not end when SUMO pauses to name a lead.
        They are watched for as long as a track survives without a detection, and count at once if they return.
        """
        last, serials = self._pairs, self._numbers(pairs)
        at, known = find(serials, self._serials)
        self._absent = np.where(last.candidate, 0.0, self._absent) + self._traffic.dt
        gone = self._absent < self._suite.coast * self._suite.cycle + self._traffic.dt / 2
        gone[at[known]] = False
        if gone.any():
            late = self._still_there(gone.nonzero()[0], rows)
            pairs = joined(pairs, self._candidates.again(last.ego[late], last.other[late], last.crossing[late]))
            serials, at = np.append(serials, self._serials[late]), np.append(at, late)
            known = np.append(known, np.ones(len(late), np.bool_))
        if known.all():
            tracks, conflict, absent = take(self._tracks, at), self._conflict[at], self._absent[at]
        else:
            tracks = track_init(self._suite, self._keys(pairs, ~known), self._traffic.dt)
            conflict, absent = np.full(len(serials), _NO_CONFLICT), np.zeros(len(serials))
            put(tracks, known, take(self._tracks, at[known]))
            conflict[known], absent[known] = self._conflict[at[known]], self._absent[at[known]]
        self._serials, self._absent = serials, absent
        return pairs, tracks, conflict, ~known

    def _still_there(self, k: Ints, rows: Ints) -> Ints:
        """Which of the rows `k` of the last step are about the same vehicles, both on the road and the ego equipped."""
        last, t = self._pairs, self._traffic
        there = mask(rows, t.capacity)[last.ego[k]] & t.here[last.other[k]]
        there &= self._numbers(take(last, k)) == self._serials[k]
        return k[there]

    def _keys(self, pairs: Pairs, new: Bools) -> Keys:
        """Identities of new pairs, for the noise of their tracks; an ideal suite has none."""
        keys = np.zeros(len(new), np.uint64)
        if self._suite.sensors:
            ids = self._traffic.ids
            for k in new.nonzero()[0].tolist():
                keys[k] = number(self._seed, "sensor", ids[pairs.ego[k]], ids[pairs.other[k]])
        return keys

    def _measurable(self, pairs: Pairs) -> Measurable:
        """The truth about the pairs, in the frame of the own front bumper."""
        t, ego, other, crossing = self._traffic, pairs.ego, pairs.other, pairs.crossing
        heading, other_heading, accel = t.heading[ego], t.heading[other], t.accel[ego]
        own_cos, own_sin = np.cos(heading), np.sin(heading)
        # A lead is measured at its rear, crossing traffic at its middle.
        behind = np.where(crossing, 0.5, 1.0) * t.length[other]
        dx = t.x[other] - behind * np.cos(other_heading) - t.x[ego]
        dy = t.y[other] - behind * np.sin(other_heading) - t.y[ego]
        ahead, left = dx * own_cos + dy * own_sin, dy * own_cos - dx * own_sin
        turned = other_heading - heading
        along, across = np.cos(turned), np.sin(turned)
        speed, other_speed, other_accel = t.speed[ego], t.speed[other], t.accel[other]
        bearing = share = turn = np.zeros(len(ego))  # which ideal suites do not ask for
        if self._suite.sensors:
            # The part of a lead's rear that is nearest to the own axis is seen.
            aside = np.where(crossing, np.abs(left), np.maximum(np.abs(left) - t.width[other] / 2, 0.0))
            bearing, share = np.arctan2(aside, ahead), self._overlap(pairs)
            turn = np.where(crossing, heading - t.old_heading[ego], 0.0)
        return Measurable(
            in_view=pairs.in_view,
            distance=np.where(crossing, ahead, pairs.gap),
            closing=speed - other_speed * along,
            closing_accel=accel - other_accel * along,
            left=left,
            closing_left=-other_speed * across,
            closing_left_accel=-other_accel * across,
            bearing=bearing,
            overlap=share,
            own_accel=accel,
            turn=turn,
        )

    def _overlap(self, pairs: Pairs) -> Floats:
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

    def _lasting(self, conflict: Floats, dangerous: Bools) -> Floats:
        """For how long conflicts have lasted, a step later [s].

        One that has lasted for long enough survives pauses, up to as long as it has been more than that: near the edge
        of the margin, what noisy tracks say comes and goes.
        """
        dt, persist = self._traffic.dt, self._suite.persist
        grown = np.minimum(np.where(conflict < 0, 0.0, conflict + dt), 2 * persist)
        shrunk = np.where(conflict - dt >= persist - dt / 2, conflict - dt, _NO_CONFLICT)
        return np.where(dangerous, grown, shrunk)

    def _in_conflict(self, pairs: Pairs, truth: Measurable, known: Measurable, locked: Bools, rows: Ints) -> Bools:
        """Which of these `rows` would be at the crossing at the same time, as far as the ego knows.

        The other is taken to be on its path as far from where it truly is as the track is along that path.
        """
        t, ego, other = self._traffic, pairs.ego[rows], pairs.other[rows]
        turned = t.heading[other] - t.heading[ego]
        along, across = np.cos(turned), np.sin(turned)  # the other's path, in the own frame
        off = (known.distance - truth.distance)[rows], (known.left - truth.left)[rows]
        farther = off[0] * along + off[1] * across
        closing, closing_left = known.closing[rows], known.closing_left[rows]
        to_zone, through_zone, other_to_zone, other_through_zone = pairs.zone[rows].T
        return conflicting(
            Approach(
                to_zone=to_zone,
                through_zone=through_zone,
                speed=t.speed[ego],
                length=t.length[ego],
                other_to_zone=other_to_zone - farther,
                other_through_zone=other_through_zone - farther,
                other_speed=(t.speed[ego] - closing) * along - closing_left * across,
                other_accel=(t.accel[ego] - known.closing_accel[rows]) * along
                - known.closing_left_accel[rows] * across,
                other_length=t.length[other],
                locked=locked[rows],
            ),
            ahead_of=self._suite.ahead_of,
        )

    def _chosen(
        self, pairs: Pairs, truth: Measurable, known: Measurable, rank: Floats, usable: Bools
    ) -> tuple[Ints, Targets]:
        """For each vehicle the usable candidate of the lowest rank; a lead before a crossing one of the same."""
        t, k = self._traffic, usable.nonzero()[0]
        k = k[np.lexsort((pairs.crossing[k], rank[k], pairs.ego[k]))]
        ego = pairs.ego[k]
        k = k[first_of_each(ego)]
        ego, other, crossing = pairs.ego[k], pairs.other[k], pairs.crossing[k]
        # Only a system that knows paths waits for crossing traffic at the crossing, where it stands in the way.
        waits = crossing & (self._gaze is Gaze.PATH)
        ahead, closing = known.distance[k], known.closing[k]
        error = ahead - truth.distance[k]
        return ego, Targets(
            slot=other,
            crossing=crossing,
            gap=np.where(waits, np.maximum(pairs.gap[k] + error, 0.0), ahead),
            speed=np.where(waits, 0.0, t.speed[ego] - closing),
            accel=np.where(waits, 0.0, t.accel[ego] - known.closing_accel[k]),
            ahead=ahead,
            left=known.left[k],
            closing_ahead=closing,
            closing_left=known.closing_left[k],
            vulnerable=t.vulnerable[other],
        )
