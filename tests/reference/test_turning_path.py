"""Turning paths of Yan et al. 2025, Table 3: end points and lengths as worked out in shared/seeds.md 4.2."""

import numpy as np
import pytest

from sumo_nets.turning_path import YAN_TABLE_3


@pytest.mark.parametrize(
    ("speed", "end", "length", "angle"),
    [
        pytest.param(10, (13.76, 13.74), 22.807, 89.92, id="Y3 10 km/h"),
        pytest.param(20, (22.32, 22.36), 37.112, 90.12, id="Y3 20 km/h"),
        pytest.param(30, (40.88, 40.82), 67.834, 89.92, id="Y3 30 km/h"),
    ],
)
def test_end_length_and_heading(speed, end, length, angle):
    points = YAN_TABLE_3[speed].points(0.01)
    assert points[-1] == pytest.approx(end, abs=0.01)
    steps = np.diff(points, axis=0)
    assert np.hypot(*steps.T).sum() == pytest.approx(length, abs=0.01)
    assert np.degrees(np.arctan2(*steps[-1][::-1])) == pytest.approx(angle, abs=0.05)
