"""What each equipped vehicle reacts to: candidates from the world, tracked by its sensors, one target chosen."""

import numpy as np

from aeb_sumo.candidates import Candidates, Pairs
from aeb_sumo.compiled import kernel
from aeb_sumo.drivers.streams import number
from aeb_sumo.perception.crossing import Approach, conflicting
from aeb_sumo.perception.ideal import Views
from aeb_sumo.perception.measurable import Measurable
from aeb_sumo.perception.noise import Keys
from aeb_sumo.perception.sensor import overlap
from aeb_sumo.perception.suites import Suite
from aeb_sumo.perception.tracking import Tracks, track_init, track_settled, track_step
from aeb_sumo.soa import Bools, Floats, Ints, find, joined, mask, put, take
from aeb_sumo.strategies.base import Gaze
from aeb_sumo.targets import Targets, choose
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.surroundings import lateral_position

__all__ = ["Lookout"]

_NO_CONFLICT = -np.inf
_NEAR_MISS = 6.0  # m, who will pass ahead at a greater lateral distance is no candidate, our assumption


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
        known = tracks.motion(truth, self._traffic.dt)
        if self._gaze is Gaze.RELATIVE_MOTION:
            nears = (known.distance > 0) & (known.closing > 0)
            rank = np.divide(known.distance, known.closing, out=np.full(len(conflict), np.inf), where=nears)
            miss = known.left - known.closing_left * np.where(np.isfinite(rank), rank, 0.0)
            counts = np.isfinite(rank) & (np.abs(miss) < _NEAR_MISS)
        else:
            judged = pairs.crossing & pairs.candidate
            if judged.any():
                dangerous = judged & tracks.watched
                locked = braking[pairs.ego] & (conflict >= 0)
                dangerous[dangerous] = self._in_conflict(pairs, truth, known, locked, dangerous.nonzero()[0])
                conflict = np.where(judged, self._lasting(conflict, dangerous), conflict)
            counts = ~pairs.crossing | (conflict >= self._suite.persist - self._traffic.dt / 2)
            rank = pairs.gap
        self._pairs, self._tracks, self._conflict = pairs, tracks, conflict
        usable = tracks.confirmed & counts & pairs.candidate
        return choose(self._traffic, pairs, truth, known, rank, usable, waiting=self._gaze is Gaze.PATH)

    def _numbers(self, pairs: Pairs) -> Ints:
        """One number per pair, which tells it from all others of the run."""
        return _numbers(self._traffic.serial, pairs.ego, pairs.other, pairs.crossing)

    def _followed(self, pairs: Pairs, rows: Ints) -> tuple[Pairs, Tracks | Views, Floats, Bools]:
        """Pairs with their tracks and conflicts from the last step, where they were there then, and who was not.

        Added to them are those that were candidates a moment ago: a track does not end when SUMO pauses to name a lead.
        They are watched for as long as a track survives without a detection, and count at once if they return.
        """
        last, serials = self._pairs, self._numbers(pairs)
        if serials.tobytes() == self._serials.tobytes():  # as mostly
            self._absent = np.where(last.candidate, 0.0, self._absent) + self._traffic.dt
            return pairs, self._tracks, self._conflict, np.zeros(len(serials), np.bool_)
        at, known = find(serials, self._serials)
        span = self._suite.coast * self._suite.cycle + self._traffic.dt / 2
        gone = _gone(last.candidate, self._absent, at, known, self._traffic.dt, span)
        if len(gone):
            late = self._still_there(gone, rows)
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
        heading, other_heading = t.heading[ego], t.heading[other]
        turned = other_heading - heading
        distance, closing, closing_accel, ahead, left, closing_left, closing_left_accel, accel = _relative(
            ego, other, crossing, pairs.gap, t.x, t.y, t.length, t.speed, t.accel,
            np.cos(heading), np.sin(heading), np.cos(other_heading), np.sin(other_heading),
            np.cos(turned), np.sin(turned),
        )  # fmt: skip
        bearing = share = turn = np.zeros(len(ego))  # which ideal suites do not ask for
        if self._suite.sensors:
            # The part of a lead's rear that is nearest to the own axis is seen.
            aside = np.where(crossing, np.abs(left), np.maximum(np.abs(left) - t.width[other] / 2, 0.0))
            bearing, share = np.arctan2(aside, ahead), self._overlap(pairs)
            turn = np.where(crossing, heading - t.old_heading[ego], 0.0)
        return Measurable(
            in_view=pairs.in_view,
            distance=distance,
            closing=closing,
            closing_accel=closing_accel,
            left=left,
            closing_left=closing_left,
            closing_left_accel=closing_left_accel,
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


@kernel
def _numbers(serial: Floats, ego: Ints, other: Ints, crossing: Bools) -> Ints:
    result = np.empty(len(ego), np.int64)
    for k in range(len(ego)):
        both = int(serial[ego[k]]) * 2**32 + int(serial[other[k]])
        result[k] = -both if crossing[k] else both  # a lead may be crossing traffic as well
    return result


@kernel
def _gone(candidate: Bools, absent: Floats, at: Ints, known: Bools, dt: float, longest: float) -> Ints:
    """Rows of the last step that are not among the pairs of this one, nor for long; `absent` is brought up to date."""
    still = np.zeros(len(candidate), np.bool_)
    for k in range(len(at)):
        if known[k]:
            still[at[k]] = True
    rows, n = np.empty(len(candidate), np.int64), 0
    for k in range(len(candidate)):
        absent[k] = (0.0 if candidate[k] else absent[k]) + dt
        if not still[k] and absent[k] < longest:
            rows[n] = k
            n += 1
    return rows[:n]


@kernel
def _relative(
    ego: Ints, other: Ints, crossing: Bools, gap: Floats, x: Floats, y: Floats, length: Floats, speed: Floats,
    accel: Floats, own_cos: Floats, own_sin: Floats, other_cos: Floats, other_sin: Floats,
    along: Floats, across: Floats,
) -> tuple[Floats, ...]:  # fmt: skip
    """Distance, closing speed and acceleration; ahead, left; closing speed and acceleration to the left; own one."""
    n = len(ego)
    distance, closing, closing_accel, ahead = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    left, closing_left, closing_left_accel, own = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    for k in range(n):
        i, j = ego[k], other[k]
        # A lead is measured at its rear, crossing traffic at its middle.
        behind = (0.5 if crossing[k] else 1.0) * length[j]
        dx, dy = x[j] - behind * other_cos[k] - x[i], y[j] - behind * other_sin[k] - y[i]
        ahead[k], left[k] = dx * own_cos[k] + dy * own_sin[k], dy * own_cos[k] - dx * own_sin[k]
        distance[k] = ahead[k] if crossing[k] else gap[k]
        closing[k], closing_accel[k] = speed[i] - speed[j] * along[k], accel[i] - accel[j] * along[k]
        closing_left[k], closing_left_accel[k] = -speed[j] * across[k], -accel[j] * across[k]
        own[k] = accel[i]
    return distance, closing, closing_accel, ahead, left, closing_left, closing_left_accel, own
