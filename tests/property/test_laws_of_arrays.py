import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from aeb_sumo.criticality import ttc, ttc2
from aeb_sumo.units import G
from aeb_sumo.vehicle.brake import BrakeParams, brake_init, brake_step
from aeb_sumo.world.boxes import Boxes, separation

gaps = st.floats(0.1, 200)
speeds = st.floats(-40, 40)
accels = st.floats(-10, 10)


@given(gaps, speeds, accels)
def test_ttc2_is_the_instant_at_which_the_gap_is_closed(gap, speed, accel):
    time = float(ttc2(gap=gap, closing_speed=speed, closing_accel=accel))
    if np.isfinite(time) and time < 1e4:
        assert abs(gap - speed * time - accel * time**2 / 2) < 1e-6 * max(1, gap, abs(speed) * time)
    if np.isfinite(time):
        before = np.linspace(0, 0.999, 50) * min(time, 1e4)
        assert np.all(gap - speed * before - accel * before**2 / 2 > -1e-6 * max(1.0, gap))


@given(gaps, st.floats(0.1, 40), st.floats(0, 10))
def test_more_closing_acceleration_is_never_later(gap, speed, accel):
    assert ttc2(gap=gap, closing_speed=speed, closing_accel=accel) <= ttc(gap=gap, closing_speed=speed) + 1e-9


pose = st.tuples(*(st.floats(-10, 10) for _ in range(2)), st.floats(-np.pi, np.pi), st.floats(1, 15), st.floats(0.5, 3))


def box(values):
    return Boxes.of(*(np.array([v]) for v in values))


@given(pose, pose)
def test_separation_is_symmetric_and_agrees_with_sampled_points(a, b):
    one, two = box(a), box(b)
    gap = separation(one, two)[0]
    assert abs(gap - separation(two, one)[0]) < 1e-9
    u, w = np.meshgrid(np.linspace(-1, 1, 15), np.linspace(-1, 1, 7))
    points = np.column_stack(
        [
            one.cx + u.ravel() * one.half_length * one.ux - w.ravel() * one.half_width * one.uy,
            one.cy + u.ravel() * one.half_length * one.uy + w.ravel() * one.half_width * one.ux,
        ]
    )
    local = np.column_stack(
        [
            (points[:, 0] - two.cx) * two.ux + (points[:, 1] - two.cy) * two.uy,
            (points[:, 1] - two.cy) * two.ux - (points[:, 0] - two.cx) * two.uy,
        ]
    )
    if np.any((np.abs(local[:, 0]) < two.half_length) & (np.abs(local[:, 1]) < two.half_width)):
        assert gap < 0


@given(st.lists(st.floats(0, 15), min_size=1, max_size=30), st.floats(0.1, 1.2), st.floats(0, 0.3))
def test_the_brake_never_exceeds_friction_and_never_pushes(demands, mu, dead_time):
    params = BrakeParams(dead_time=dead_time)
    state = brake_init(params, 1, 0.1)
    for demand in demands:
        state, decel = brake_step(params, state, demand=np.array([demand]), mu=np.array([mu]), dt=0.1)
        assert 0 <= decel[0] <= mu * G + 1e-9
