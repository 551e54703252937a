"""Several systems in one run."""

import pandas as pd
import pytest

from aeb_sumo import scenarios
from aeb_sumo.equipment import Equipment
from aeb_sumo.errors import InputError
from aeb_sumo.results import TABLES
from aeb_sumo.simulate import run
from aeb_sumo.trace import Trace
from tests.helpers import approach, vehicle


def frames(results, labels):
    return {name: results.frame(name).drop(columns=["run_id", *(labels if name == "runs" else [])]) for name in TABLES}


TEXTS = ["passenger:zhao2025=1", "zhao2025=1,yan2025=0", "lin2021=0,zhao2025=1,truck:yan2025=0"]


def test_everybody_with_one_system_is_a_run_of_that_system():
    """Whether it is said for all cars or for a class of them, and with another system at hand that nobody has."""
    plain = run(scenarios.load("w0"), "zhao2025", duration=70)
    assert len(plain.interventions) > 0
    for text in TEXTS:
        mix = run(scenarios.load("w0"), equip=text, duration=70)
        labels = ["strategy", "sensing", "penetration"]
        for table, frame in frames(mix, labels).items():
            pd.testing.assert_frame_equal(frame, frames(plain, labels)[table])


def test_verdicts_do_not_depend_on_a_system_that_nobody_has():
    """In a fork the AEB that is withheld does nothing, whoever comes and goes meanwhile."""
    plain = run(scenarios.load("highway"), "zhao2025", duration=90, seed=2, verdicts="all")
    assert (plain.interventions["acted_by"] != "").sum() > 3
    mix = run(scenarios.load("highway"), equip="zhao2025=1,yan2025=0", duration=90, seed=2, verdicts="all")
    pd.testing.assert_frame_equal(*(each.interventions.drop(columns="run_id") for each in (plain, mix)))


def test_one_system_in_a_share_of_the_cars_is_the_run_of_that_penetration():
    mix = run(scenarios.load("highway"), equip="zhao2025/radar=0.4", duration=60)
    plain = run(scenarios.load("highway"), "zhao2025", sensing="radar", penetration=0.4, duration=60)
    for name in TABLES:
        assert mix.tables[name].equals(plain.tables[name]), name


def test_until_the_first_action_each_car_sees_and_knows_the_same_as_in_a_run_of_its_own_system():
    """Up to the first warning of all, the runs are the same traffic, and the noise of its sensors is a car's own."""

    def recorded(**given):
        trace = Trace()
        result = run(scenarios.load("w0").varied(demand=2.0), **given, duration=60, trace=trace)
        frame = trace.frame()
        return result, frame, frame.loc[frame["phase"] > 0, "time_s"].min()

    mix, seen, begin = recorded(equip="zhao2025=0.4,lin2021/fusion=0.6")
    pure = {"zhao2025": recorded(strategy="zhao2025"), "lin2021/fusion": recorded(strategy="lin2021", sensing="fusion")}
    first = min(begin, *(run_begin for _, _, run_begin in pure.values()))
    equipment = Equipment.parse(mix.runs["strategy"].item())
    for name, (_, alone, _) in pure.items():
        early, there = (frame[(frame["time_s"] <= first) & frame["mu_known"].notna()] for frame in (seen, alone))
        systems = [equipment.of(v, vtype="car", vclass="passenger", seed=1) for v in early["vehicle"]]
        own = early[[system.name == name for system in systems]]
        assert (own["target"] != "").sum() > 2
        pd.testing.assert_frame_equal(
            own.reset_index(drop=True), there[there["vehicle"].isin(own["vehicle"])].reset_index(drop=True)
        )


def test_a_vehicle_type_can_have_its_own_system(on_track):
    """Two cars far apart run into standing ones: one type brakes late, the other early, the third not at all."""
    types = "".join(f'<vType id="{t}" vClass="passenger" length="4.6" width="1.82"/>' for t in ("a", "b", "c"))
    pairs = "".join(
        vehicle(f"{t}.wall", 600 * k + 204.6, 0) + vehicle(f"{t}.ego", 600 * k + 100, 15, kind=t)
        for k, t in enumerate(("a", "b", "c"))
    )
    trace = Trace("a.ego", "b.ego", "c.ego")
    result = run(on_track(types + pairs), equip="a:zhao2025=1,b:staged/ideal=1", duration=12, trace=trace)
    braked = result.interventions.dropna(subset="brake_s").set_index("vehicle")
    assert braked["strategy"].to_dict() == {"a.ego": "zhao2025", "b.ego": "staged/ideal"}
    assert braked.loc["a.ego", "trigger_ttc_s"] > braked.loc["b.ego", "trigger_ttc_s"]
    crash = result.crashes.set_index("striker")
    assert crash.loc["c.ego", "striker_strategy"] == ""
    assert set(result.exposure["strategy"]) == {"", "zhao2025", "staged/ideal"}
    frame = trace.frame()
    assert frame.groupby("vehicle")["target"].max().to_dict() == {"a.ego": "a.wall", "b.ego": "b.wall", "c.ego": ""}
    assert frame.groupby("vehicle")["mu_known"].count().gt(0).to_dict() == {
        "a.ego": True,
        "b.ego": True,
        "c.ego": False,
    }


def test_the_system_of_a_crashed_car_is_in_the_books(on_track):
    scenario = on_track(approach(90, 0, 12))
    crash = run(scenario, equip="car:staged=1", duration=5).crashes.iloc[0]
    assert (crash["striker_strategy"], crash["struck_strategy"]) == ("staged", "staged")
    assert crash["striker_equipped"]


def test_a_kind_that_the_scenario_does_not_have_is_refused(on_track):
    with pytest.raises(InputError, match=r"'lorry'.*attentive, car"):
        run(on_track(approach(50, 50, 40)), equip=Equipment.parse("lorry:zhao2025=1"))
