"""Sensing: detection, confirmation, loss and tracking, on approaches made of numbers."""

from dataclasses import replace

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter

from aeb_sumo.errors import InputError
from aeb_sumo.kalman import Gaussian, predict, update
from aeb_sumo.perception.measurable import Measurable
from aeb_sumo.perception.noise import normals, uniforms
from aeb_sumo.perception.sensor import detection, overlap
from aeb_sumo.perception.suites import RADAR, SUITES, suite
from aeb_sumo.perception.tracking import track_init, track_settled, track_step

DT = 0.01


def truth(distance, closing, share=1.0, in_view=True):
    n = np.size(distance)

    def full(value):
        return np.full(n, float(value))

    return Measurable(
        in_view=np.full(n, in_view), distance=np.asarray(distance, float).reshape(n), closing=full(closing),
        closing_accel=full(0), left=full(0), closing_left=full(0), closing_left_accel=full(0), bearing=full(0),
        overlap=full(share),
        own_accel=full(0), turn=full(0),
    )  # fmt: skip


def approach(sensors, share=1.0, n=200, start=40.0, closing=5.556, keys=None):
    """Distances at which each of n vehicles confirms a target that it closes in on, and the last tracks."""
    tracks = track_init(sensors, np.arange(1, n + 1, dtype=np.uint64) if keys is None else keys, DT)
    confirmed_at, time, gap = np.full(n, np.nan), 0.0, start
    while gap > 1.0:
        time, gap = time + DT, gap - closing * DT
        tracks = track_step(sensors, tracks, truth(np.full(n, gap), closing, share), time=time, dt=DT)
        new = tracks.confirmed & np.isnan(confirmed_at)
        confirmed_at[new] = gap
    return confirmed_at, tracks


def test_noise_is_uniform_and_normal_and_depends_on_who_and_when_alone():
    keys, frames = np.arange(20_000, dtype=np.uint64), np.full(20_000, 7)
    u, z = uniforms(keys, frames, 1), normals(keys, frames, 2)
    assert abs(u.mean() - 0.5) < 0.01
    assert abs(u.std() - 12**-0.5) < 0.01
    assert abs(z.mean()) < 0.03
    assert abs(z.std() - 1) < 0.02
    assert np.array_equal(u[5:9], uniforms(keys[5:9], frames[5:9], 1))
    assert abs(np.corrcoef(u, uniforms(keys, frames + 1, 1))[0, 1]) < 0.03


def test_detection_falls_with_range_and_grows_with_overlap():
    ranges = np.linspace(1, 150, 50)
    for share in (0.3, 0.5, 1.0):
        sensor = replace(RADAR, lost=(0.0, 0.0))
        assert np.all(np.diff(detection(sensor, distance=ranges, share=np.full(50, share))) <= 0)
    at_12 = [detection(RADAR, distance=np.array([12.0]), share=np.array([s]))[0] for s in (0.5, 1.0)]
    assert at_12[0] < 0.01
    assert at_12[1] > 0.99


def test_overlap():
    half = overlap(left=np.array([0.0, 0.91, 1.82, 3.0]), width=np.full(4, 1.82), target_width=np.full(4, 1.82))
    assert half == pytest.approx([1.0, 0.5, 0.0, 0.0])


def test_an_ideal_suite_confirms_after_its_time_and_tells_the_truth():
    ideal, tracks = suite("ideal"), track_init(suite("ideal"), np.zeros(1, np.uint64), 0.1)
    seen = truth([30.0], 5.0)
    for k in range(4):
        tracks = track_step(ideal, tracks, seen, time=0.1 * k, dt=0.1)
        assert tracks.confirmed[0] == (k >= 2), "0.2 s after the first sight"
        assert tracks.motion(seen, 0.1) is seen
    assert not track_step(ideal, tracks, truth([30.0], 5.0, in_view=False), time=0.5, dt=0.1).confirmed[0]


def test_the_radar_sees_half_of_a_car_late_and_the_camera_earlier():
    radar, _ = approach(suite("radar"), share=0.5)
    fusion, _ = approach(suite("fusion"), share=0.5)
    assert np.nanmax(radar) < 10.4
    assert np.nanmean(fusion) - np.nanmean(radar) > 3
    whole, _ = approach(suite("radar"), share=1.0)
    assert np.nanmin(whole) > 35


def test_confirmation_takes_m_of_n_frames():
    """Three of five frames of 0.05 s: never before the third frame, soon after it."""
    _, first = approach(replace(suite("radar"), confirm=(3, 5)), start=40.0)
    tracks = track_init(suite("radar"), np.arange(1, 101, dtype=np.uint64), DT)
    counts = []
    for k in range(60):
        tracks = track_step(suite("radar"), tracks, truth(np.full(100, 30.0), 0.0), time=(k + 1) * DT, dt=DT)
        counts.append(int(tracks.confirmed.sum()))
    assert counts[9] == 0
    assert counts[-1] == 100
    assert first.confirmed.all()


def test_a_track_is_lost_when_it_is_not_detected_for_long_enough():
    sensors = suite("radar")
    tracks = track_init(sensors, np.arange(1, 11, dtype=np.uint64), DT)
    for k in range(100):
        tracks = track_step(sensors, tracks, truth(np.full(10, 30.0), 0.0), time=k * DT, dt=DT)
    assert tracks.confirmed.all()
    for k in range(100, 100 + round((sensors.coast + 1) * sensors.cycle / DT)):
        tracks = track_step(sensors, tracks, truth(np.full(10, 30.0), 0.0, in_view=False), time=k * DT, dt=DT)
    assert not tracks.confirmed.any()


def test_estimates_are_near_the_truth():
    _, tracks = approach(suite("fusion"), n=500)
    known = tracks.motion(truth(np.full(500, 1.0), 5.556), DT)
    assert np.abs(known.distance - 1.0).mean() < 0.1
    assert np.abs(known.closing - 5.556).mean() < 0.1


def test_latency_is_extrapolated_away():
    late = replace(suite("radar"), latency=0.1)
    _, tracks = approach(late, n=300)
    known = tracks.motion(truth(np.full(300, 1.0), 5.556), DT)
    assert abs(tracks.along[:, 0].mean() - 1.0) > 0.4, "what was measured is old"
    assert abs(known.distance.mean() - 1.0) < 0.1


@pytest.mark.parametrize("latency", [0.0, 0.05, 0.1])
def test_a_car_that_turns_knows_where_a_standing_target_is(latency):
    """0.4 rad/s to the left, a target 20 m ahead and 5 m to the left at the start."""
    sensors, n, rate = replace(suite("fusion"), latency=latency), 300, 0.4
    tracks = track_init(sensors, np.arange(1, n + 1, dtype=np.uint64), DT)
    for k in range(100):
        angle = rate * DT * (k + 1)
        ahead, left = 20 * np.cos(angle) + 5 * np.sin(angle), 5 * np.cos(angle) - 20 * np.sin(angle)
        seen = replace(truth(np.full(n, ahead), 0.0), left=np.full(n, left), turn=np.full(n, rate * DT))
        tracks = track_step(sensors, tracks, seen, time=DT * (k + 1), dt=DT)
    known = tracks.motion(seen, DT)
    assert abs(known.left.mean() - left) < 0.05
    assert abs(known.distance.mean() - ahead) < 0.05


@pytest.mark.parametrize("latency", [0.0, 0.1])
def test_own_braking_is_known_and_not_taken_for_the_targets(latency):
    """8 m/s2 from 15 m/s behind a lead at 10 m/s: the closing speed is right at every instant."""
    sensors, n, decel = replace(suite("radar"), latency=latency), 300, 8.0
    tracks = track_init(sensors, np.arange(1, n + 1, dtype=np.uint64), DT)
    closing, gap = 5.0, 30.0
    for k in range(150):
        braking = decel if k >= 100 else 0.0
        gap, closing = gap - closing * DT + braking * DT**2 / 2, closing - braking * DT
        seen = replace(truth(np.full(n, gap), closing), own_accel=np.full(n, -braking))
        tracks = track_step(sensors, tracks, seen, time=DT * (k + 1), dt=DT)
    known = tracks.motion(seen, DT)
    assert abs(known.closing.mean() - closing) < 0.1
    assert abs(known.distance.mean() - gap) < 0.1


@pytest.mark.parametrize(("dt", "steps"), [(0.1, 1), (0.05, 1), (0.02, 3), (0.01, 5)])
def test_latency_in_steps(dt, steps):
    """To the nearest step, half a step up."""
    assert track_init(suite("radar"), np.zeros(1, np.uint64), dt).past.shape[1] == steps


def test_a_batch_equals_the_singles():
    keys = np.arange(1, 21, dtype=np.uint64)
    batch, tracks = approach(suite("fusion"), n=20, keys=keys)
    for k in (0, 7, 19):
        one, track = approach(suite("fusion"), n=1, keys=keys[k : k + 1])
        assert one[0] == batch[k]
        assert np.allclose(track.along[0], tracks.along[k])


def test_the_tracker_equals_filterpy():
    """Constant acceleration, distance and rate measured in turn, with frames left out."""
    rng = np.random.default_rng(0)
    n, dt = 5, 0.05
    transition = np.array([[1, dt, dt**2 / 2], [0, 1, dt], [0, 0, 1]])
    process, start = 0.3 * np.eye(3), np.diag([25.0, 100.0, 9.0])
    batch = Gaussian(rng.normal(0, 5, (n, 3)), np.repeat(start[None], n, 0))
    singles = []
    for k in range(n):
        f = KalmanFilter(3, 1)
        f.x, f.P, f.F, f.Q = batch.mean[k].copy(), start.copy(), transition, process
        singles.append(f)
    for step in range(50):
        batch = predict(batch, transition, process)
        for f in singles:
            f.predict()
        for row, variance in (([1.0, 0, 0], 0.01), ([0, 1.0, 0], 0.0025)):
            measured, use = rng.normal(0, 3, n), rng.random(n) < 0.7
            batch = update(batch, np.array(row), variance, measured, use)
            for k, f in enumerate(singles):
                if use[k]:
                    f.update(measured[k], R=variance, H=np.array([row]))
        assert np.allclose(batch.mean, [f.x for f in singles], rtol=1e-9, atol=1e-9), step
        assert np.allclose(batch.cov, [f.P for f in singles], rtol=1e-9, atol=1e-9), step


def test_suites_by_name():
    assert set(SUITES) == {"ideal", "radar", "camera", "fusion", "perfect"}
    with pytest.raises(InputError, match="unknown sensing 'lidar'; there are: ideal, radar, camera, fusion"):
        suite("lidar")


@pytest.mark.parametrize("name", ["ideal", "radar", "fusion"])
def test_a_settled_track_counts_at_once_and_knows_what_measurements_show(name):
    eyes, n, dt = suite(name), 400, 0.1
    keys = np.arange(1, n + 1, dtype=np.uint64)
    now = truth(np.full(n, 40.0), 10.0)
    tracks = track_step(eyes, track_settled(eyes, keys, now, dt), now, time=20.0, dt=dt)
    assert tracks.confirmed.all()
    known = tracks.motion(now, dt)
    assert np.abs(known.distance - 40.0).mean() < 0.15
    assert np.abs(known.closing - 10.0).mean() < 0.15


def test_what_no_sensor_would_detect_has_no_settled_track():
    keys = np.array([1, 2], np.uint64)
    radar = suite("radar")
    far, unseen = truth(np.full(2, 200.0), 10.0), truth(np.full(2, 40.0), 10.0, in_view=False)
    for hidden in (far, unseen):
        assert not track_settled(radar, keys, hidden, 0.1).confirmed.any()
    assert not track_step(
        suite("ideal"), track_settled(suite("ideal"), keys, unseen, 0.1), unseen, time=1.0, dt=0.1
    ).confirmed.any()
