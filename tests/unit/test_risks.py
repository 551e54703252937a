"""Whose risk a crash has a curve for."""

from dataclasses import replace

import pytest

from aeb_sumo.ledger.severity import risks
from aeb_sumo.severity import death_risk, serious_risk
from aeb_sumo.world.contact import Impact

HIT = Impact(
    time=1.0, x=0.0, y=0.0, striker=0, struck=1, striker_speed=12.0, struck_speed=5.0, impact_speed=13.0,
    striker_delta_v=1.0, struck_delta_v=12.0, approach=12.0, at_rear=False, angle=1.5,
)  # fmt: skip


def test_a_rider_hit_by_a_car():
    columns = risks(HIT, "crossing", ["passenger", "bicycle"])
    assert columns == {
        "striker_death_risk": None,
        "striker_serious_risk": None,
        "struck_death_risk": pytest.approx(death_risk(12.0)),
        "struck_serious_risk": pytest.approx(serious_risk("cyclist", 13.0)),
    }


def test_drivers_of_cars_in_a_head_on_crash_are_both_at_risk_and_in_a_rear_end_crash_the_struck():
    both = risks(HIT, "head_on", ["passenger", "taxi"])
    assert (
        both["striker_serious_risk"] == both["struck_serious_risk"] == pytest.approx(serious_risk("car_driver", 13.0))
    )
    assert both["striker_death_risk"] is both["struck_death_risk"] is None
    assert risks(HIT, "rear_end", ["passenger", "taxi"])["striker_serious_risk"] is None


@pytest.mark.parametrize("classes", [["bicycle", "passenger"], ["truck", "bicycle"], ["passenger", "bus"]])
def test_no_curve_for_riders_who_run_into_cars_nor_with_heavy_vehicles(classes):
    assert set(risks(HIT, "crossing", classes).values()) == {None}


def test_a_rider_who_meets_a_car_head_on_is_hit_by_its_front():
    columns = risks(replace(HIT, striker_speed=5.0, struck_speed=12.0), "head_on", ["bicycle", "passenger"])
    assert columns["striker_death_risk"] == pytest.approx(death_risk(12.0))
