"""What holds for every registered strategy in the traffic scenarios, and for every sensor suite."""

import pytest

from aeb_sumo import scenarios, strategies
from aeb_sumo.perception.suites import SUITES
from aeb_sumo.results import TABLES
from aeb_sumo.simulate import run

TRAFFIC = (("highway", 50), ("w0", 90))


@pytest.mark.parametrize(("scenario", "duration"), TRAFFIC, ids=[name for name, _ in TRAFFIC])
@pytest.mark.parametrize("name", [n for n in strategies.names() if n != "none"])
def test_runs_and_every_command_is_executed(scenario, duration, name):
    result = run(scenarios.load(scenario), name, duration=duration)
    runs = result.runs.iloc[0]
    assert runs["outcome"] == "completed"
    assert runs["equipped"] > 5
    assert runs["override_violations"] == 0
    assert runs["sensing"] == strategies.load(name).sensing
    if not strategies.load(name).sees_crossing:
        assert (result.interventions["target_kind"] != "crossing").all()
    acting = result.interventions["max_decel_mps2"]
    assert (acting <= 0.85 * 9.81 + 1e-9).all()


@pytest.mark.parametrize("sensing", SUITES)
def test_the_same_run_twice_is_the_same_with_every_suite(sensing):
    twice = [run(scenarios.load("w0"), "zhao2025", sensing=sensing, duration=60) for _ in range(2)]
    assert len(twice[0].interventions) > 0
    for name in TABLES:
        assert twice[0].tables[name].equals(twice[1].tables[name]), name


@pytest.mark.parametrize("sensing", ["radar", "fusion"])
def test_what_an_aeb_sees_does_not_depend_on_who_else_has_one(sensing):
    """The noise of a vehicle is its own: the first intervention of a run comes at the same instant."""
    both = [run(scenarios.load("w0"), "zhao2025", sensing=sensing, penetration=p, duration=60) for p in (1.0, 0.5)]
    first = both[1].interventions.sort_values("begin_s").iloc[0]
    same = both[0].interventions.query("vehicle == @first.vehicle")["begin_s"].min()
    assert same == first["begin_s"]


@pytest.mark.parametrize("name", ["yan2025", "zhao2025"])
def test_who_sees_crossing_traffic_acts_on_it(name):
    assert strategies.load(name).sees_crossing
    result = run(scenarios.load("w0"), name, duration=120)
    assert (result.interventions["target_kind"] == "crossing").any()
