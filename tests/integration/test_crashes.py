"""Crash truth, from SUMO to the table."""

import pytest

from aeb_sumo.simulate import run
from tests.helpers import approach, vehicle


def test_a_rear_end_crash_is_one_event_with_its_physics(on_track):
    result = run(on_track(approach(50, 20, 30)), "none")
    (crash,) = result.crashes.itertuples()
    assert (crash.kind, crash.striker, crash.struck) == ("rear_end", "ego", "lead")
    # Both have departed at the end of the first step, at 0.1 s; 30 km/h close 30 m in 3.6 s.
    assert crash.time_s == pytest.approx(0.1 + 30 / (30 / 3.6), abs=1e-3)
    assert crash.impact_speed_mps == pytest.approx(30 / 3.6, abs=1e-6)
    assert crash.striker_delta_v_mps == pytest.approx(15 / 3.6, abs=1e-6)
    assert crash.x_m == pytest.approx(630 + 20 / 3.6 * 3.6, abs=0.1)
    assert crash.striker_error == "robot"
    assert crash.sumo_reported
    assert result.runs["sumo_collisions"].item() == result.runs["confirmed_by_sumo"].item() == 1


def test_wrecks_block_for_their_time_and_leave(on_track):
    vehicles = approach(50, 20, 30) + vehicle("late", 300, 10, kind="attentive")
    scenario = on_track(vehicles, duration=60.0)
    blocked = run(scenario, "none", blockage=40.0)
    assert len(blocked.crashes) >= 1
    assert blocked.exposure["vehicles"].sum() == 3
    short = run(scenario, "none", blockage=5.0)
    assert short.traffic["time_s"].sum() < blocked.traffic["time_s"].sum() - 50


def test_a_pile_up_is_one_event_per_pair(on_track):
    third = vehicle("third", 560, 14)
    crashes = run(on_track(approach(50, 20, 30) + third), "none").crashes
    assert crashes[["striker", "struck"]].to_numpy().tolist() == [["ego", "lead"], ["third", "ego"]]
    assert crashes["secondary"].tolist() == [False, True]


def test_small_steps_do_not_change_the_truth(on_track):
    coarse, fine = (run(on_track(approach(50, 20, 30)), "none", step_length=h).crashes.iloc[0] for h in (0.5, 0.02))
    assert coarse["impact_speed_mps"] == pytest.approx(fine["impact_speed_mps"], abs=1e-3)
    assert coarse["time_s"] - 0.5 == pytest.approx(fine["time_s"] - 0.02, abs=0.01)


@pytest.mark.parametrize("strategy", ["none", "zhao2025"])
def test_left_turn_across_an_e_bike(strategy, tmp_path):
    """A driver who never looks, and a rider who never reacts: a crash without AEB, none with it."""
    from aeb_sumo.drivers.encounters import FailureToYield
    from aeb_sumo.drivers.profile import Profile
    from aeb_sumo.scenarios import Scenario
    from sumo_nets import folder

    routes = tmp_path / "r.rou.xml"
    routes.write_text(
        '<routes><vType id="car" vClass="passenger" length="4.6" width="1.82" sigma="0" speedDev="0"/>'
        '<vType id="bike" vClass="bicycle" length="1.8" width="0.7" maxSpeed="5" sigma="0" speedDev="0"/>'
        '<route id="left" edges="si wo"/><route id="on" edges="ni so"/>'
        '<vehicle id="car" type="car" route="left" depart="0" departLane="1" departPos="170" departSpeed="10"/>'
        '<vehicle id="bike" type="bike" route="on" depart="0" departLane="0" departPos="214" departSpeed="5"/></routes>'
    )
    scenario = Scenario(
        name="w0",
        options=("-n", str(folder("w0") / "w0.net.xml"), "-r", str(routes)),
        drivers=Profile(failure_to_yield=FailureToYield(probability=1.0, rider_unaware=1.0)),
        duration=30,
    )
    result = run(scenario, strategy)
    if strategy == "none":
        (crash,) = result.crashes.itertuples()
        assert crash.kind == "left_turn_across_path"
        assert {crash.striker, crash.struck} == {"car", "bike"}
        assert "failure_to_yield" in {crash.striker_error, crash.struck_error}
        assert 0 < crash.impact_speed_mps < 12
    else:
        assert len(result.crashes) == 0
        row = result.interventions.iloc[0]
        assert (row["target"], row["target_kind"]) == ("bike", "crossing")
        assert row["speed_reduction_mps"] > 1
