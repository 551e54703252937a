"""Tracks: from what sensors detect, frame by frame, to confirmed targets with estimated motion; one row per pair."""

from dataclasses import dataclass, fields, replace

import numpy as np

from aeb_sumo.kalman import Gaussian, predict, update
from aeb_sumo.perception.ideal import UNSEEN, Views, seen_for
from aeb_sumo.perception.measurable import Measurable
from aeb_sumo.perception.noise import Keys, normals, uniforms
from aeb_sumo.perception.sensor import detection
from aeb_sumo.perception.suites import Suite
from aeb_sumo.soa import Bools, Floats, Ints

__all__ = ["Tracks", "track_init", "track_settled", "track_step"]

_ACROSS = 2.0  # m/s2 within a second, lateral manoeuvres that the tracker expects, our assumption
# Standard deviations of a track at its first detection [m, m/s, m/s2], our assumption.
_FIRST_ALONG = np.array([5.0, 10.0, 3.0])
_FIRST_ACROSS = np.array([2.0, 10.0])
# Of the acceleration of a target that has been followed for long [m/s2], our assumption.
_SETTLED_ACCEL = 0.5
# What a measurement shows of the state.
_DISTANCE = np.array([1.0, 0.0, 0.0])
_RATE = np.array([0.0, 1.0, 0.0])
_LEFT = np.array([1.0, 0.0])


_TURN = [f.name for f in fields(Measurable)].index("turn")


@dataclass(frozen=True)
class Tracks:
    """Memory and output of the tracker, one row per pair of a vehicle and a target.

    Attributes:
        key: (n,) identity of the pair, for its noise.
        history: (n,) detections of the last frames, one bit each, newest lowest.
        confirmed: (n,) counts as a target.
        along: (n, 3) and (n, 3, 3) estimate of distance, its rate, and the target's own acceleration.
        along_cov: see `along`.
        across: (n, 2) and (n, 2, 2) estimate of the lateral position and its rate.
        across_cov: see `across`.
        past: (n, k, m) what could have been measured within the latency, oldest first (see `Measurable`).
    """

    key: Keys
    history: Keys
    confirmed: Bools
    along: Floats
    along_cov: Floats
    across: Floats
    across_cov: Floats
    past: Floats

    @property
    def watched(self) -> Bools:
        """(n,) there is something to judge: it has been detected of late."""
        result: Bools = self.history != 0
        return result

    def motion(self, truth: Measurable, dt: float) -> Measurable:
        """The estimates, brought to the present.

        They are moved on and turned with the own frame: the latency is a whole number of steps of `dt` [s].
        """
        t = self.past.shape[1] * dt
        turn = np.nansum(self.past[:, :, _TURN], axis=1)
        distance, rate, accel = self.along.T
        accel = accel - truth.own_accel
        left, left_rate = self.across.T
        distance, left = _rotated(distance + rate * t + accel * t**2 / 2, left + left_rate * t, turn)
        rate, left_rate = _rotated(rate + accel * t, left_rate, turn)
        return Measurable(
            in_view=truth.in_view,
            distance=distance,
            closing=-rate,
            closing_accel=-accel,
            left=left,
            closing_left=-left_rate,
            closing_left_accel=np.zeros(len(left)),  # the filter knows none
            bearing=truth.bearing,
            overlap=truth.overlap,
            own_accel=truth.own_accel,
            turn=truth.turn,
        )


def track_init(suite: Suite, keys: Keys, dt: float) -> Tracks | Views:
    """Memory of pairs that have not been seen yet: `Views` of an ideal suite, or `Tracks`."""
    n = len(keys)
    if not suite.sensors:
        return Views(key=keys, seen=np.full(n, UNSEEN), confirmed=np.zeros(n, np.bool_))
    return Tracks(
        key=keys,
        history=np.zeros(n, np.uint64),
        confirmed=np.zeros(n, np.bool_),
        along=np.zeros((n, 3)),
        along_cov=np.zeros((n, 3, 3)),
        across=np.zeros((n, 2)),
        across_cov=np.zeros((n, 2, 2)),
        past=np.full((n, int(suite.latency / dt + 0.5 + 1e-9), len(fields(Measurable))), np.nan),
    )


def track_settled(suite: Suite, keys: Keys, truth: Measurable, dt: float) -> Tracks | Views:
    """Tracks of targets that have been followed for long, as before the present step: confirmed, and well known.

    They are known as well as one measurement of the best sensor shows. What none of the sensors would
    detect in every second frame where it is now has no track yet.
    """
    tracks = track_init(suite, keys, dt)
    if isinstance(tracks, Views):
        return replace(tracks, seen=np.where(truth.in_view, suite.persist, UNSEEN))
    clear = np.zeros(len(keys), np.bool_)
    for sensor in suite.sensors:
        sees = truth.in_view & (truth.bearing <= np.radians(sensor.field_of_view / 2))
        clear |= sees & (detection(sensor, distance=truth.distance, share=truth.overlap) >= 0.5)
    best = [min(getattr(s, name) for s in suite.sensors) for name in ("range_noise", "rate_noise", "lateral_noise")]
    spread = np.array([best[0], best[1], _SETTLED_ACCEL])
    first = np.zeros(len(keys), np.int64)
    noise = [normals(keys, first, channel) for channel in (5, 6, 7)]  # which frames do not use
    past, ages = tracks.past, np.arange(tracks.past.shape[1], 0, -1) * dt
    for k, age in enumerate(ages):
        then = _earlier(truth, float(age))
        past[:, k] = np.column_stack([getattr(then, f.name).astype(float) for f in fields(then)])
    then = _earlier(truth, (len(ages) + 1) * dt)  # the step to come brings it to the age of the latency
    along = np.column_stack([then.distance, -then.closing, then.own_accel - then.closing_accel])
    return replace(
        tracks,
        history=np.where(clear, np.uint64(2 ** suite.confirm[1] - 1), np.uint64(0)),
        confirmed=clear,
        along=along + np.column_stack(noise) * spread,
        along_cov=np.tile(np.diag(spread**2), (len(keys), 1, 1)),
        across=np.column_stack([then.left, -then.closing_left]),
        across_cov=np.tile(np.diag([best[2] ** 2, best[2] ** 2]), (len(keys), 1, 1)),
        past=past,
    )


def _earlier(truth: Measurable, age: float) -> Measurable:
    """What could have been measured `age` [s] ago, if the relative acceleration was the same."""
    closing = truth.closing - truth.closing_accel * age
    return replace(
        truth,
        distance=truth.distance + truth.closing * age - truth.closing_accel * age**2 / 2,
        closing=closing,
        left=truth.left + truth.closing_left * age,
    )


def track_step(suite: Suite, tracks: Tracks | Views, truth: Measurable, *, time: float, dt: float) -> Tracks | Views:
    """One step of `dt` [s] that ends at `time` [s]: detect, confirm, filter.

    An ideal suite confirms what has been in view for `Suite.persist`. Any other takes the frames that fall into the
    step; in each, every sensor detects with the probability of `detection` or not at all, and measures with noise.
    """
    if isinstance(tracks, Views):
        seen = seen_for(tracks.seen, truth.in_view, dt)
        return Views(key=tracks.key, seen=seen, confirmed=seen >= suite.persist - dt / 2)
    truth, past = _delayed(tracks.past, truth)
    tracks = _predicted(_turned(replace(tracks, past=past), truth.turn), suite, truth.own_accel, dt)
    # Every vehicle's frames have a phase of their own.
    phase = uniforms(tracks.key, np.zeros(len(tracks.key), np.int64), 0)
    before = np.floor((time - dt) / suite.cycle + phase).astype(np.int64)
    after = np.floor(time / suite.cycle + phase).astype(np.int64)
    for extra in range(int((after - before).max(initial=0))):
        frame = before + 1 + extra
        tracks = _frame(suite, tracks, truth, frame, now=frame <= after)
    return tracks


def _delayed(past: Floats, truth: Measurable) -> tuple[Measurable, Floats]:
    """What could be measured a latency ago, and the memory for the next step."""
    if not past.shape[1]:
        return truth, past
    now = np.column_stack([getattr(truth, name).astype(float) for name in (f.name for f in fields(truth))])
    old = past[:, 0]
    known = ~np.isnan(old[:, 0])
    values = np.where(known[:, None], old, now)
    in_view = known & (old[:, 0] > 0)
    return Measurable(in_view, *values.T[1:]), np.concatenate([past[:, 1:], now[:, None]], axis=1)


def _turned(tracks: Tracks, turn: Floats) -> Tracks:
    """The estimates in the own frame as it has turned meanwhile."""
    if not turn.any():
        return tracks
    ahead, left = _rotated(tracks.along[:, :2], tracks.across, turn[:, None])
    return replace(tracks, along=np.column_stack([ahead, tracks.along[:, 2]]), across=left)


def _rotated(ahead: Floats, left: Floats, turn: Floats) -> tuple[Floats, Floats]:
    """A vector in a frame that has turned to the left by `turn` [rad]."""
    cos, sin = np.cos(turn), np.sin(turn)
    return cos * ahead + sin * left, cos * left - sin * ahead


def _predicted(tracks: Tracks, suite: Suite, own_accel: Floats, dt: float) -> Tracks:
    """Constant acceleration along, constant velocity across; white jerk and acceleration drive them."""
    q = suite.manoeuvre**2
    along = predict(
        Gaussian(tracks.along, tracks.along_cov),
        np.array([[1.0, dt, dt**2 / 2], [0.0, 1.0, dt], [0.0, 0.0, 1.0]]),
        q
        * dt
        * np.array([[dt**4 / 20, dt**3 / 8, dt**2 / 6], [dt**3 / 8, dt**2 / 3, dt / 2], [dt**2 / 6, dt / 2, 1.0]]),
    )
    across = predict(
        Gaussian(tracks.across, tracks.across_cov),
        np.array([[1.0, dt], [0.0, 1.0]]),
        _ACROSS**2 * dt * np.array([[dt**2 / 3, dt / 2], [dt / 2, 1.0]]),
    )
    # What the own car does is known: only the target's acceleration has to be guessed.
    moved = along.mean - own_accel[:, None] * np.array([dt**2 / 2, dt, 0.0])
    return replace(tracks, along=moved, along_cov=along.cov, across=across.mean, across_cov=across.cov)


def _frame(suite: Suite, tracks: Tracks, truth: Measurable, frame: Ints, *, now: Bools) -> Tracks:
    """One frame of those rows that have one `now`."""
    hits = np.zeros(len(frame), np.bool_)
    fresh = tracks.history == 0
    found = []
    for k, sensor in enumerate(suite.sensors):
        chance = detection(sensor, distance=truth.distance, share=truth.overlap)
        sees = truth.in_view & (truth.distance <= sensor.reach)
        sees &= truth.bearing <= np.radians(sensor.field_of_view / 2)
        hit = now & sees & (uniforms(tracks.key, frame, 8 * k + 1) < chance)
        found.append(hit)
        hits |= hit
    along = Gaussian(tracks.along, tracks.along_cov)
    across = Gaussian(tracks.across, tracks.across_cov)
    starts = hits & fresh
    if starts.any():
        along, across = _started(along, across, starts, truth)
    for k, (sensor, hit) in enumerate(zip(suite.sensors, found, strict=True)):
        noise = [normals(tracks.key, frame, 8 * k + c) for c in (2, 3, 4)]
        along = update(along, _DISTANCE, sensor.range_noise**2, truth.distance + sensor.range_noise * noise[0], hit)
        if np.isfinite(sensor.rate_noise):
            along = update(along, _RATE, sensor.rate_noise**2, sensor.rate_noise * noise[1] - truth.closing, hit)
        across = update(across, _LEFT, sensor.lateral_noise**2, truth.left + sensor.lateral_noise * noise[2], hit)
    history = np.where(now, (tracks.history << np.uint64(1)) | hits.astype(np.uint64), tracks.history)
    m, n = suite.confirm
    enough = np.bitwise_count(history & np.uint64(2**n - 1)) >= m
    alive = (history & np.uint64(2**suite.coast - 1)) != 0
    history = np.where(alive, history, np.uint64(0))
    return replace(
        tracks,
        history=history,
        confirmed=(tracks.confirmed | (enough & (along.cov[:, 1, 1] <= suite.sure**2))) & alive,
        along=along.mean,
        along_cov=along.cov,
        across=across.mean,
        across_cov=across.cov,
    )


def _started(along: Gaussian, across: Gaussian, rows: Bools, truth: Measurable) -> tuple[Gaussian, Gaussian]:
    """New tracks at the first detection: somewhere there, rates unknown."""
    zero = np.zeros_like(truth.distance)
    wide = rows[:, None]
    return (
        Gaussian(
            np.where(wide, np.column_stack([truth.distance, zero, zero]), along.mean),
            np.where(wide[:, None], np.diag(_FIRST_ALONG**2), along.cov),
        ),
        Gaussian(
            np.where(wide, np.column_stack([truth.left, zero]), across.mean),
            np.where(wide[:, None], np.diag(_FIRST_ACROSS**2), across.cov),
        ),
    )
