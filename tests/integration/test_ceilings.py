"""Crashes of a baseline against forks of the world with perfect braking and a careful driver."""

import os
import signal

import pytest

from aeb_sumo import scenarios, strategies
from aeb_sumo.ceilings import CEILINGS, ceilings
from aeb_sumo.engine import Engine
from aeb_sumo.equipment import Equipment
from aeb_sumo.errors import InputError
from aeb_sumo.results import TABLES
from aeb_sumo.scenarios.cases import approach, left_turn
from aeb_sumo.simulate import run
from aeb_sumo.units import KMH, G
from aeb_sumo.world.fork import Forks
from tests.helpers import vehicle

MU = 0.85
EVERY = Equipment.parse(",".join(f"{name}=0" for name in strategies.names() if name != "none"))


def ccr(speed, gap, lead=0.0, mu=MU, **values):
    return approach("ccr", ego=speed, lead=lead, gap=gap, mu=mu, step_length=0.1, duration=10.0, **values)


def judged(scenario, *, beside=None, **options):
    """Ceiling -> row, of a scenario with one crash."""
    found = ceilings(scenario, run(scenario, "none", **options), beside=beside).ceilings
    assert found["crash_id"].unique().tolist() == [0]
    return {row["ceiling"]: row for row in found.to_dict("records")}


def test_perfect_avoids_what_the_careful_driver_does_not():
    rows = judged(ccr(80 * KMH, 150.0))
    assert list(rows) == ["perfect", "careful"]
    assert {name: row["outcome"] for name, row in rows.items()} == {"perfect": "avoided", "careful": "mitigated"}
    perfect, careful = rows.values()
    assert perfect["braked_s"] < careful["braked_s"]
    assert perfect["with_impact_speed_mps"] != perfect["with_impact_speed_mps"], "null without a crash"
    assert 0 < careful["with_impact_speed_mps"] < careful["without_impact_speed_mps"] == pytest.approx(80 * KMH)
    assert careful["with_delta_v_mps"] == pytest.approx(careful["with_impact_speed_mps"] / 2)
    assert careful["with_serious_risk"] < careful["without_serious_risk"]
    assert careful["equipped"] == "ego"


@pytest.mark.parametrize("kmh", [10, 20, 30])
def test_both_avoid_the_left_turn_across_an_e_bike(kmh):
    rows = judged(left_turn("turn", ego_kmh=kmh, step_length=0.05))
    assert {row["outcome"] for row in rows.values()} == {"avoided"}
    assert {row["equipped"] for row in rows.values()} == {"ego"}, "nobody equips an e-bike"


def test_a_perfect_sensor_sees_at_once_and_all_around():
    scenario = left_turn("turn", ego_kmh=30, step_length=0.05)
    system = strategies.load("perfect", {"horizon": 60.0})
    brakes = [run(scenario, system, sensing=suite).interventions["brake_s"].min() for suite in ("perfect", "ideal")]
    assert brakes[0] <= brakes[1] - 0.15


def test_who_is_nearer_than_the_stopping_distance_is_not_avoided():
    speed = 15.0
    stopping = speed**2 / (2 * MU * G)
    for share, outcome in ((0.5, "mitigated"), (0.9, "mitigated"), (1.2, "avoided")):
        row = judged(ccr(speed, share * stopping))["perfect"]
        assert row["outcome"] == outcome, share
        if outcome == "mitigated":  # from the second step on: the first has begun when the world is forked
            left = speed**2 - 2 * MU * G * share * stopping
            assert left**0.5 <= row["with_impact_speed_mps"] <= (left + 2 * MU * G * 0.25 * speed) ** 0.5


def test_a_slippery_road_avoids_no_more():
    impact = [judged(ccr(20.0, 60.0, mu=mu))["perfect"] for mu in (0.9, 0.4, 0.2, 0.1)]
    speeds = [0.0 if row["outcome"] == "avoided" else row["with_impact_speed_mps"] for row in impact]
    assert speeds == sorted(speeds)
    assert speeds[0] == 0 < speeds[-1]


CASES = {
    "ccrs 80": ccr(80 * KMH, 100.0),
    "ccrs 40, near": ccr(40 * KMH, 6.0),
    "ccrs 70, wet": ccr(70 * KMH, 120.0, mu=0.4),
    "ccrm 80": ccr(80 * KMH, 60.0, lead=20 * KMH),
    "ccrb 50": ccr(50 * KMH, 14.0, lead=50 * KMH, braking=(0.5, 4.0)),
    "ccrb 50, near and hard": ccr(50 * KMH, 3.0, lead=40 * KMH, braking=(0.5, 8.0)),
}


def test_the_cases_hold_some_that_nobody_can_avoid():
    outcomes = {name: judged(CASES[name])["perfect"]["outcome"] for name in ("ccrs 80", "ccrs 40, near")}
    assert outcomes == {"ccrs 80": "avoided", "ccrs 40, near": "mitigated"}


@pytest.mark.parametrize("case", CASES)
def test_no_strategy_avoids_what_perfect_does_not(case):
    rows = judged(CASES[case], beside=EVERY)
    assert set(rows) == set(strategies.names()) - {"none"}
    perfect = rows["perfect"]
    for name, row in rows.items():
        assert row["outcome"] != "unknown"
        if perfect["outcome"] != "avoided":
            assert row["outcome"] != "avoided", name
            assert row["with_impact_speed_mps"] >= perfect["with_impact_speed_mps"] - 0.01, name


@pytest.fixture(scope="module")
def traffic():
    """`w0` until its first crash: a driver who turns left overlooks an e-bike."""
    scenario = scenarios.load("w0")
    return scenario, run(scenario, "none", seed=1, duration=89)


def test_in_traffic_no_strategy_avoids_what_perfect_does_not(traffic):
    found = ceilings(*traffic, beside=EVERY).ceilings.set_index("ceiling")
    assert len(traffic[1].crashes) == 1
    assert found["outcome"]["perfect"] == "avoided"
    assert found["outcome"]["careful"] == "mitigated"
    assert found["outcome"]["staged"] == "unchanged", "it has no eyes for crossing traffic"
    assert (found["forked_s"] < 80).all()


def test_all_other_tables_stay_as_they_are_and_the_same_comes_out_again():
    scenario = ccr(20.0, 60.0)
    baseline = run(scenario, "none")
    found, again = ceilings(scenario, baseline), ceilings(scenario, baseline)
    for name in TABLES:
        assert found.tables[name].equals(again.tables[name]), name
        if name != "ceilings":
            assert found.tables[name].equals(baseline.tables[name]), name
    assert found.tables["ceilings"].schema.equals(TABLES["ceilings"].arrow(), check_metadata=True)


def test_a_run_without_crashes_has_no_ceilings():
    scenario = ccr(5.0, 1000.0)
    assert ceilings(scenario, run(scenario, "none")).ceilings.empty


def test_who_follows_into_the_equipped_one_is_another_crash(on_track):
    """The wreck of the baseline is gone when the third one comes; the car that stops in time stands in its way."""
    scenario = on_track(vehicle("lead", 200, 0) + vehicle("ego", 100, 20) + vehicle("late", 8, 20), duration=12.0)
    rows = judged(scenario, blockage=0.2)
    assert rows["perfect"]["outcome"] == "other"
    assert rows["perfect"]["other"] == "late"
    assert rows["perfect"]["with_impact_speed_mps"] > 10


def test_who_is_pushed_by_one_who_hit_him_anyway_has_avoided_the_crash(on_track):
    scenario = on_track(vehicle("lead", 200, 0) + vehicle("ego", 100, 20) + vehicle("late", 50, 20), duration=12.0)
    baseline = run(scenario, "none")
    assert baseline.crashes[["striker", "struck"]].to_numpy().tolist() == [["ego", "lead"], ["late", "ego"]]
    found = ceilings(scenario, baseline).ceilings
    perfect = found[found["ceiling"] == "perfect"]
    assert perfect["equipped"].tolist() == ["ego", "late"]
    assert perfect["outcome"].tolist() == ["avoided", "avoided"]


def test_what_it_would_do_about_others_before_the_crash_is_near_does_not_count(on_track):
    """A car that the ego closes in on at a TTC of 3 s and less leaves the road before the crash with another."""
    where = 'depart="7" departLane="0" departPos="285" departSpeed="10" arrivalPos="310" insertionChecks="none"'
    passing = f'<vehicle id="mid" type="car" route="r" {where}/>'
    scenario = on_track(vehicle("lead", 400, 0) + vehicle("ego", 100, 20) + passing, duration=18.0)
    row = judged(scenario)["perfect"]
    assert row["outcome"] == "avoided"
    assert row["braked_s"] == pytest.approx(row["forked_s"] + 5.0, abs=0.25), "3 s before the crash, for the lead"
    alone = run(scenario, "perfect").interventions.iloc[0]
    assert alone["target"] == "mid"
    assert alone["begin_s"] < row["braked_s"] - 1


def test_nobody_to_equip_is_a_crash_that_no_brake_avoids(on_track):
    scenario = on_track(vehicle("lead", 200, 0) + vehicle("ego", 150, 5, kind="DEFAULT_BIKETYPE"), duration=20.0)
    row = judged(scenario)["perfect"]
    assert (row["equipped"], row["outcome"]) == ("", "unchanged")
    assert row["reason"] == "no motor vehicle whose braking could help"


def test_another_course_of_the_second_run_is_said():
    baseline = run(ccr(20.0, 60.0), "none")
    found = ceilings(ccr(20.0, 70.0), baseline).ceilings
    assert set(found["outcome"]) == {"unknown"}
    assert set(found["reason"]) == {"the second run had other crashes than the first"}


def test_an_interrupted_second_run_is_said():
    scenario = ccr(20.0, 60.0)
    found = ceilings(scenario, run(scenario, "none"), stop=lambda: True).ceilings
    assert set(found["outcome"]) == {"unknown"}
    assert set(found["reason"]) == {"the second run was interrupted"}


def test_a_fork_that_takes_too_long_is_unknown():
    scenario = ccr(20.0, 60.0)
    found = ceilings(scenario, run(scenario, "none"), forks=Forks(limit=8, patience=0.0)).ceilings
    assert set(found["outcome"]) == {"unknown"}
    assert set(found["reason"]) == {"the fork was not done within 0 s"}


def test_a_child_that_dies_is_unknown_and_the_others_go_on(monkeypatch):
    scenario, parent = ccr(20.0, 60.0), os.getpid()
    equip = Engine.equip

    def die(engine, slot, system):
        if system == "careful" and os.getpid() != parent:
            os.kill(os.getpid(), signal.SIGKILL)
        equip(engine, slot, system)

    monkeypatch.setattr(Engine, "equip", die)
    rows = judged(scenario)
    assert rows["perfect"]["outcome"] == "avoided"
    assert rows["careful"]["outcome"] == "unknown"
    assert rows["careful"]["reason"] == "the fork was ended by signal 9"


def test_what_is_no_baseline_is_refused_in_one_line():
    scenario = ccr(20.0, 60.0)
    with pytest.raises(InputError, match=r"^ceilings are those of a baseline, strategy none, not zhao2025$"):
        ceilings(scenario, run(scenario, "zhao2025"))
    with pytest.raises(InputError, match=r"^the baseline is one of scenario ccr, not highway$"):
        ceilings(scenarios.load("highway"), run(scenario, "none"))


def test_ceilings_are_found_by_their_names():
    assert set(CEILINGS) <= set(strategies.names())
