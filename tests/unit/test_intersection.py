"""Intersections from parameters: their geometry, and what cannot be built."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from sumo_nets.intersection import ARMS, LEFT, OPPOSITE, RIGHT, Intersection
from sumo_nets.plain import connections
from sumo_nets.turning_path import YAN_TABLE_3, turning_path


@st.composite
def intersections(draw):
    values = {
        "arms": draw(st.sampled_from(["nesw", "nsw", "new", "esw", "nes"])),
        "lanes": draw(st.integers(1, 4)),
        "lane_width": draw(st.floats(2.5, 4.0)),
        "bike_lane": draw(st.floats(0.8, 3.0)),
        "median": draw(st.floats(0.0, 5.0)),
        "separation": draw(st.floats(0.0, 3.0)),
        "turn_radius": draw(st.floats(10.0, 29.0)),
        "signal": draw(st.booleans()),
        "bike_left": draw(st.sampled_from(["two_stage", "one_stage", "none"])),
        "contraflow": draw(st.booleans()),
        "setback": draw(st.sampled_from([0.0, 2.0, 6.0])),
    }
    try:
        return Intersection(**values)
    except ValueError:
        assume(False)


@given(intersections())
def test_the_offset_is_the_sum_of_what_lies_between(it):
    parts = it.lane_width / 2, it.median, it.lanes * it.lane_width, it.separation, it.bike_lane / 2
    assert it.offset == pytest.approx(sum(parts))


@given(intersections())
def test_stop_lines_lie_outside_of_the_crossing_road(it):
    assert it.stop >= it.half_width + 2


@given(intersections())
def test_a_left_turn_ends_in_the_innermost_lane_beyond(it):
    path, _ = it.turn
    forward, left = path.points(0.5).T
    x, y = it.at("s", it.stop - float(forward[-1]), it.inner - float(left[-1]))
    assert y == pytest.approx(it.inner, abs=0.01)
    assert x == pytest.approx(-it.stop, abs=0.1)


@given(intersections())
def test_every_lane_of_an_arm_leads_somewhere_and_every_movement_has_a_lane(it):
    rows = connections(it)
    for arm in it.arms:
        cars = {(r["fromLane"], r["to"]) for r in rows if r["from"] == f"{arm}i" and r["fromLane"]}
        assert {lane for lane, _ in cars} == set(range(1, it.lanes + 1))
        assert {to for _, to in cars} == {f"{to}o" for to in it.movements(arm).values()}


@given(intersections())
def test_with_several_lanes_the_innermost_is_for_left_turns_alone(it):
    for arm in it.arms:
        if it.lanes > 1 and LEFT[arm] in it.arms:
            beyond = {r["to"] for r in connections(it) if r["from"] == f"{arm}i" and r["fromLane"] == it.lanes}
            assert beyond == {f"{LEFT[arm]}o"}


@given(intersections())
def test_cars_turn_clear_of_buildings_and_of_riders_who_wait(it):
    arc = np.array([it.at("e", *p) for p in it.right_turn(1)])
    corner = [it.at("s", *p) for p in it.waiting_area("s")] if {"n", "e"} <= set(it.arms) else []
    for x, y in corner:
        assert np.hypot(arc[:, 0] - x, arc[:, 1] - y).min() > 0.91 + 0.35
    for ring in it.buildings().values():
        assert min(math.dist(a, b) for a in ring for b in arc) > 0.91


@pytest.mark.parametrize("speed", YAN_TABLE_3)
def test_radii_of_table_3_are_taken_as_printed(speed):
    path, at = turning_path(YAN_TABLE_3[speed].r_turn)
    assert path == YAN_TABLE_3[speed]
    assert at == pytest.approx(speed / 3.6)


def test_between_them_a_turn_is_a_right_angle():
    path, at = turning_path(13.0)
    assert 2 * path.clothoid_angle + path.arc_angle == pytest.approx(90)
    assert at == pytest.approx(15 / 3.6)


def test_arms_are_named_clockwise():
    for arm in ARMS:
        assert RIGHT[LEFT[arm]] == arm
        assert OPPOSITE[OPPOSITE[arm]] == arm


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"median": -1.0}, r"median must be within 0 .. 30, not -1"),
        ({"lane_width": math.nan}, r"lane_width must be within 2.5 .. 4, not nan"),
        ({"lanes": 5}, r"lanes must be within 1 .. 4, not 5"),
        ({"turn_radius": 9.0}, r"turn_radius must be within 10 .. 29, not 9"),
        ({"arms": "ns"}, r"arms must be three or four of \"nesw\", each once, not 'ns'"),
        ({"arms": "nnsw"}, r"arms must be three or four"),
        ({"bike_left": "three"}, r"bike_left must be one of two_stage, one_stage, none, not 'three'"),
        ({"turn_radius": 10.0, "lanes": 4}, r"turn_radius 10 m does not fit: .* the stop line lies"),
        ({"turn_radius": 10.0, "median": 8.0}, r"median 8 m does not fit turn_radius 10 m|turn_radius 10 m does not"),
        ({"arm_length": 60.0, "turn_radius": 29.0}, r"arm_length must be 69 m or more"),
        ({"setback": 90.0}, r"setback must be 36 m or less, not 90"),
    ],
)
def test_what_cannot_be_built_is_named_in_one_line(values, message):
    with pytest.raises(ValueError, match=message) as caught:
        Intersection(**values)
    assert "\n" not in str(caught.value)
