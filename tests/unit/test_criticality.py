import numpy as np
import pytest

from aeb_sumo.criticality import (
    crossing_ttc,
    drac,
    pet,
    required_decel,
    thw,
    time_below,
    ttc,
    ttc2,
    yielding_decel,
)


@pytest.mark.parametrize(
    ("gap", "speed", "expected"), [(20, 10, 2.0), (20, 0, np.inf), (20, -5, np.inf), (0, 10, 0.0), (-1, -5, 0.0)]
)
def test_ttc(gap, speed, expected):
    assert ttc(gap=gap, closing_speed=speed) == expected


@pytest.mark.parametrize(
    ("gap", "speed", "accel", "expected"),
    [
        pytest.param(20, 10, 0, 2.0, id="row 3: constant speeds"),
        pytest.param(18, 0, 4, 3.0, id="row 1: lead starts to brake"),
        pytest.param(20, 8, 2, 2.0, id="row 2"),
        pytest.param(7, -2, 4, (2 + np.sqrt(4 + 56)) / 4, id="opening now, closing later"),
        pytest.param(20, 4, -2, np.inf, id="stops closing before contact"),
        pytest.param(20, 0, 0, np.inf, id="never"),
        pytest.param(20, -3, -1, np.inf, id="opening"),
        pytest.param(20, 10, 1e-12, 2.0, id="tiny acceleration keeps its precision"),
        pytest.param(-0.1, 5, 0, 0.0, id="contact"),
        pytest.param(np.inf, 5, 1, np.inf, id="nothing ahead"),
    ],
)
def test_ttc2(gap, speed, accel, expected):
    assert ttc2(gap=gap, closing_speed=speed, closing_accel=accel) == pytest.approx(expected)


def test_thw_is_the_time_gap():
    assert thw(gap=[30, 30, 0, np.inf], speed=[20, 0, 20, 20]).tolist() == [1.5, np.inf, 0, np.inf]


def test_drac_brings_the_ego_to_the_leads_speed_within_the_gap():
    assert drac(gap=[10, 10, 10, 0, np.inf], closing_speed=[10, 0, -10, 5, 5]).tolist() == [5, 0, 0, np.inf, 0]


@pytest.mark.parametrize(
    ("gap", "speed", "lead_speed", "lead_accel", "expected"),
    [
        pytest.param(10, 20, 10, 0, 5.0, id="lead at constant speed: drac"),
        pytest.param(10, 20, 10, -2, 7.0, id="equal speeds while the lead still brakes: drac and its deceleration"),
        pytest.param(40, 20, 20, -5, 400 / (2 * 80), id="both stop: within the gap and the lead's stopping distance"),
        pytest.param(50, 20, 0, 0, 4.0, id="standing lead"),
        pytest.param(50, 20, 0, -3, 4.0, id="a standing lead cannot brake"),
        pytest.param(50, 20, 22, -8, 400 / (2 * (50 + 484 / 16)), id="opening, but the lead brakes to a stop"),
        pytest.param(50, 20, 22, 0, 0.0, id="opening"),
        pytest.param(10, 20, 10, 2, 3.0, id="accelerating lead"),
        pytest.param(10, 20, 10, 9, 0.0, id="lead accelerates away"),
        pytest.param(0, 20, 30, 0, np.inf, id="contact"),
        pytest.param(np.inf, 20, 10, -9, 0.0, id="nothing ahead"),
    ],
)
def test_required_decel(gap, speed, lead_speed, lead_accel, expected):
    answer = required_decel(gap=gap, speed=speed, lead_speed=lead_speed, lead_accel=lead_accel)
    assert answer == pytest.approx(expected)


def test_crossing_ttc_is_when_the_second_enters_while_the_first_is_inside():
    times = {"enter": [1, 1, 1, 0, 2], "leave": [3, 3, np.inf, 2, 4]}
    other = {"other_enter": [2, 3.5, 9, 0, np.inf], "other_leave": [4, 5, 10, 1, np.inf]}
    assert crossing_ttc(**times, **other).tolist() == [2, np.inf, 9, 0, np.inf]


@pytest.mark.parametrize(
    ("distance", "speed", "until", "expected"),
    [
        pytest.param(20, 10, np.inf, 2.5, id="stop"),
        pytest.param(20, 10, 4, 2.5, id="just stopped when it is free"),
        pytest.param(20, 10, 3, 2 * (30 - 20) / 9, id="rolls in when it is free"),
        pytest.param(20, 10, 2, 0.0, id="arrives when it is free"),
        pytest.param(20, 10, 0, 0.0, id="free"),
        pytest.param(-1, 10, 2, np.inf, id="inside"),
        pytest.param(20, 0, np.inf, 0.0, id="stands"),
    ],
)
def test_yielding_decel(distance, speed, until, expected):
    assert yielding_decel(distance=distance, speed=speed, until=until) == pytest.approx(expected)


def test_pet():
    assert pet(leave=[5, 5, np.inf, 5], enter=[6.5, 4, 4, np.inf]).tolist() == [1.5, -1, np.inf, np.inf]


def test_time_below_counts_whole_steps():
    assert time_below([1.4, 1.5, np.inf], 1.5, dt=0.1).tolist() == [0.1, 0, 0]
