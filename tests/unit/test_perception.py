import numpy as np
import pytest

from aeb_sumo.perception.crossing import Approach, conflicting, crossing_zone
from aeb_sumo.perception.lead import sees_lead


def approach(**values):
    defaults = {
        "to_zone": 10.0, "through_zone": 13.0, "speed": 5.0, "length": 4.6, "other_to_zone": 10.0,
        "other_through_zone": 13.0, "other_speed": 5.0, "other_accel": 0.0, "other_length": 1.8, "locked": False,
    }  # fmt: skip
    return Approach(**{k: np.array([v]) for k, v in (defaults | values).items()})


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        pytest.param({}, True, id="both arrive together"),
        pytest.param({"other_to_zone": 40.0, "other_through_zone": 43.0}, False, id="the other comes much later"),
        pytest.param({"other_to_zone": -9.0, "other_through_zone": -6.0}, False, id="the other has passed"),
        pytest.param({"other_speed": 0.0}, False, id="the other waits before the crossing"),
        pytest.param({"other_speed": 0.0, "other_to_zone": -1.0, "other_through_zone": 2.0}, True, id="stands in it"),
        pytest.param({"other_accel": -3.0}, False, id="the other stops in time"),
        pytest.param({"other_to_zone": 0.0, "other_through_zone": 1.0}, False, id="the other leaves first"),
        pytest.param(
            {"other_to_zone": 0.0, "other_through_zone": 1.0, "locked": True}, True, id="locked until it has left"
        ),
        pytest.param({"to_zone": -2.0, "through_zone": 1.0}, False, id="too late to brake"),
    ],
)
def test_conflicting(values, expected):
    assert conflicting(approach(**values))[0] == expected


def test_who_is_through_just_in_time_is_in_conflict_only_with_a_margin_to_spare():
    just = approach(other_to_zone=18.0, other_through_zone=21.0)  # through after 3.52 s, the other comes after 3.6
    assert conflicting(just)[0]
    assert not conflicting(just, ahead_of=0.0)[0]
    late = approach(other_to_zone=0.0, other_through_zone=7.6)  # the other is through after 1.88 s, 0.12 s before
    assert conflicting(late)[0]
    assert conflicting(late, ahead_of=0.0)[0]


def line(x0, y0, heading, n=80, spacing=0.5):
    s = np.arange(n) * spacing
    return np.column_stack([x0 + s * np.cos(heading), y0 + s * np.sin(heading)]), np.full(n, heading)


def test_zone_of_paths_at_right_angles():
    zone = crossing_zone(*line(0, 0, 0), *line(20, -20, np.pi / 2), width=1.3, spacing=0.5)
    assert zone is not None
    assert (zone.own_from, zone.own_to) == (19.0, 21.0)
    assert (zone.other_from, zone.other_to) == (19.0, 21.0)


def test_paths_side_by_side_or_one_behind_the_other_do_not_cross():
    assert crossing_zone(*line(0, 0, 0), *line(0, 3, np.pi), width=1.8, spacing=0.5) is None
    assert crossing_zone(*line(0, 0, 0), *line(5, 0, 0), width=1.8, spacing=0.5) is None


def lead(gap=20.0, rear_x=20.0, rear_y=0.0, lead_heading=0.0):
    ends = {"x": np.array([0.0, rear_x]), "y": np.array([0.0, rear_y]), "heading": np.array([0.0, lead_heading])}
    rows = {"ego": np.array([0]), "lead": np.array([1]), "gap": np.array([gap])}
    return sees_lead(150.0, 70.0, **rows, **ends, length=np.zeros(2))[0]


def test_lead():
    assert lead()
    assert not lead(gap=200.0, rear_x=200.0), "out of range"
    assert not lead(rear_x=14.0, rear_y=14.0), "out of view"
    assert not lead(lead_heading=np.pi / 2), "another way"
    assert not lead(gap=5.0), "SUMO's gap to a merging point, not to the vehicle"
    assert lead(gap=1.0, rear_x=0.5, rear_y=0.6), "bumper to bumper"
