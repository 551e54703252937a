import numpy as np
import pytest

from aeb_sumo.criticality import ttc, ttc2


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
