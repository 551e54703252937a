import numpy as np
import pytest

from aeb_sumo.world.boxes import Boxes, distance, separation
from aeb_sumo.world.contact import impact, touching
from aeb_sumo.world.observe import Traffic

DT = 0.1


def boxes(*rows):
    return Boxes.of(*(np.array(column, float) for column in zip(*rows, strict=True)))


def traffic(*vehicles):
    """Vehicles as (x, y, heading, old speed, speed, length, width, mass); they have driven straight for a step."""
    t = Traffic(DT)
    n = len(vehicles)
    x, y, heading, old, speed, length, width, mass = (np.array(c, float) for c in zip(*vehicles, strict=True))
    way = (old + speed) / 2 * DT
    t.x, t.y, t.heading, t.speed = x, y, heading, speed
    t.old_x, t.old_y = x - way * np.cos(heading), y - way * np.sin(heading)
    t.old_heading, t.old_speed = heading.copy(), old
    t.length, t.width, t.mass = length, width, mass
    t.sudden, t.here = np.zeros(n, bool), np.ones(n, bool)
    t.present = np.arange(n)
    return t


@pytest.mark.parametrize(
    ("other", "expected"),
    [
        pytest.param((7, 0, 0, 4, 2), -1 + 0, id="overlapping by 1 m"),
        pytest.param((10, 0, 0, 4, 2), 2, id="2 m ahead"),
        pytest.param((4, 3, 0, 4, 2), 1, id="1 m beside"),
        pytest.param((5, 0.5, np.pi / 2, 1, 1), 0.5, id="across, half a metre ahead"),
    ],
)
def test_separation(other, expected):
    a, b = boxes((4, 0, 0, 4, 2)), boxes(other)
    assert separation(a, b)[0] == pytest.approx(expected)
    assert separation(b, a)[0] == pytest.approx(expected)


def test_rear_end_contact_is_interpolated_inside_the_step():
    # The gap is 0.6 m before the step, and 1.5 m are closed in it: contact after 0.04 s.
    t = traffic((100.9, 0, 0, 15, 15, 5, 2, 1500), (105, 0, 0, 0, 0, 5, 2, 1500))
    t.x[0], t.old_x[0] = 100.9, 99.4
    pairs, when = touching(t, t.present)
    assert pairs.tolist() == [[0, 1]]
    assert when[0] * DT == pytest.approx(0.04, abs=1e-4)
    hit = impact(t, pairs[0], float(when[0]), 10.0)
    assert hit.time == pytest.approx(9.94, abs=1e-4)
    assert (hit.striker, hit.struck) == (0, 1)
    assert hit.at_rear
    assert hit.impact_speed == pytest.approx(15)
    assert hit.x == pytest.approx(100, abs=0.05)
    assert hit.striker_delta_v == pytest.approx(7.5)


def test_speed_at_contact_is_interpolated():
    t = traffic((100.5, 0, 0, 10, 9, 5, 2, 1500), (105, 0, 0, 0, 0, 5, 2, 1500))
    pairs, when = touching(t, t.present)
    hit = impact(t, pairs[0], float(when[0]), 1.0)
    assert hit.impact_speed == pytest.approx(10 - when[0])


def test_passing_through_within_a_step_is_seen():
    """At 1 s steps a fast car jumps over an e-bike unseen if only the ends of steps are looked at."""
    t = Traffic(1.0)
    for name, value in (
        ("x", [110, 100]), ("y", [0, 5]), ("old_x", [90, 100]), ("old_y", [0, -5]), ("heading", [0, np.pi / 2]),
        ("old_heading", [0, np.pi / 2]), ("speed", [20, 10]), ("old_speed", [20, 10]), ("length", [4.6, 1.8]),
        ("width", [1.8, 0.7]), ("mass", [1500, 120]),
    ):  # fmt: skip
        setattr(t, name, np.array(value, float))
    t.sudden, t.present = np.zeros(2, bool), np.arange(2)
    pairs, when = touching(t, t.present)
    assert len(pairs) == 1
    assert 0.3 < when[0] < 0.6


def test_the_car_is_the_striker_of_a_crossing_bike_it_hits_with_its_front():
    t = traffic((50.2, 0, 0, 10, 10, 4.6, 1.8, 1500), (50.4, 0.9, np.pi / 2, 5, 5, 1.8, 0.7, 120))
    pairs, when = touching(t, t.present)
    hit = impact(t, pairs[0], float(when[0]), 1.0)
    assert hit.striker == 0
    assert hit.impact_speed == pytest.approx(np.hypot(10, 5))
    assert hit.angle == pytest.approx(np.pi / 2)
    momentum = np.array([1500 * 10, 120 * 5]) / 1620
    assert hit.struck_delta_v == pytest.approx(np.hypot(momentum[0], momentum[1] - 5))


def test_a_jump_is_no_motion():
    t = traffic((100, 0, 0, 10, 10, 5, 2, 1500), (95, 3.2, 0, 10, 10, 4, 2, 1500))
    t.old_y[1] = -3.2  # put across the first one's lane at once, as SUMO changes lanes
    assert len(touching(t, t.present)[0]) == 0


def test_standing_side_by_side_is_no_contact():
    t = traffic((100, 0, 0, 0, 0, 5, 2, 1500), (100, 2.01, 0, 0, 0, 5, 2, 1500))
    assert len(touching(t, t.present)[0]) == 0


def test_distance_of_bodies():
    """Face to face 2 m; corner to corner 3 and 4 m, where the largest gap along an axis is only 4 m; overlapping."""
    own = boxes(*[(0, 0, 0, 4, 2)] * 3)
    other = boxes((6, 0, 0, 4, 2), (7, 6, 0, 4, 2), (3, 0.5, 0, 4, 2))
    assert distance(own, other) == pytest.approx([2.0, 5.0, 0.0])
    assert distance(other, own) == pytest.approx([2.0, 5.0, 0.0])
    assert separation(own, other)[:2] == pytest.approx([2.0, 4.0])
