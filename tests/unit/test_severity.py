import numpy as np
import pytest

from aeb_sumo.severity import ROAD_USERS, death_risk, serious_risk
from aeb_sumo.units import KMH


@pytest.mark.parametrize(("kmh", "percent"), [(30, 2.9), (50, 23), (60, 50), (80, 90)])
def test_risk_of_death_meets_the_points_of_the_source(kmh, percent):
    assert 100 * death_risk(kmh * KMH) == pytest.approx(percent, abs=2.0)


@pytest.mark.parametrize(
    ("user", "kmh"), [("pedestrian", 29), ("cyclist", 44), ("motorcyclist", 48), ("car_driver", 112)]
)
def test_ten_percent_are_seriously_injured_where_the_source_says(user, kmh):
    # The printed coefficients have three decimals: 0.0005 of 0.041 alone moves the car driver's point by 1.4 km/h.
    assert serious_risk(user, (kmh - 1.5) * KMH) < 0.1 < serious_risk(user, (kmh + 1.5) * KMH)


def test_risks_are_probabilities_that_rise_with_speed_and_age():
    speed = np.linspace(0, 200, 101)
    for risk in (death_risk(speed), *(serious_risk(user, speed) for user in ROAD_USERS)):
        assert (np.diff(risk) >= 0).all()
        assert risk[0] < 0.03
        assert 0.99 < risk[-1] <= 1
    assert serious_risk("cyclist", 10.0, age=70) > serious_risk("cyclist", 10.0, age=20)


def test_the_less_protected_are_at_the_greater_risk():
    order = ("car_driver", "motorcyclist", "cyclist", "pedestrian")
    assert sorted(order, key=lambda user: serious_risk(user, 15.0)) == list(order)
