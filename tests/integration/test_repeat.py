from pathlib import Path

import pandas as pd
import pytest

from aeb_sumo import scenarios, strategies
from aeb_sumo.drivers import profile
from aeb_sumo.equipment import Equipment
from aeb_sumo.errors import InputError
from aeb_sumo.repeat import settings
from aeb_sumo.simulate import run

CROSSING = Path(__file__).parents[1] / "data" / "crossing" / "crossing.net.xml"


def row(scenario, equip, **options):
    return run(scenario, equip=equip, duration=0.4, **options).runs.iloc[0].to_dict()


def of(strategy, **parameters):
    return Equipment.single(strategies.load(strategy, parameters))


@pytest.mark.parametrize(
    ("name", "variation", "drivers", "equip"),
    [
        ("track", {}, None, Equipment()),
        ("track", {"weather": "wet"}, None, of("staged")),
        ("track", {"weather": "wet", "mu": 0.45}, "careful", of("zhao2025", comfort_decel=5.0)),
        ("w0", {"demand": 1 / 3}, None, Equipment.single("zhao2025", "radar", penetration=1 / 3)),
        ("w0", {"ebike_share": 0.5, "mu": 0.6}, None, Equipment.parse("zhao2025=0.3,yan2025=0.2")),
        (
            "221",
            {"demand": 1.5},
            "highway",
            Equipment.parse("passenger:zhao2025/radar=0.5,truck:yan2025=0.25", {"yan2025": {"brake.lag": 0.2}}),
        ),
    ],
)
def test_a_run_comes_back_from_its_row(name, variation, drivers, equip):
    scenario = scenarios.load(name).varied(**variation, drivers=profile.load(drivers) if drivers else None)
    back = settings(row(scenario, equip, seed=7, step_length=0.2, blockage=12.5))
    assert back.scenario == scenario
    assert back.equip == equip
    assert (back.seed, back.step_length, back.blockage) == (7, 0.2, 12.5)
    assert back.duration == pytest.approx(0.4)


def test_a_configuration_and_a_driver_file_of_ones_own_come_back(tmp_path):
    routes = tmp_path / "r.rou.xml"
    routes.write_text('<routes><vType id="car" vClass="passenger"/></routes>')
    config = tmp_path / "my.sumocfg"
    config.write_text(
        f'<configuration><net-file value="{CROSSING}"/><route-files value="{routes}"/><scale value="1.3"/>'
        '<begin value="30"/></configuration>'
    )
    mine = tmp_path / "mine.toml"
    mine.write_text(profile.text("highway"))
    scenario = scenarios.from_sumocfg(config).varied(demand=0.7, drivers=profile.load(str(mine)))
    back = settings(row(scenario, of("zhao2025"), seed=3))
    assert back.scenario == scenario
    assert back.scenario.drivers.name == str(mine)
    assert back.duration == pytest.approx(0.4)
    config.unlink()
    with pytest.raises(InputError, match=r"no such SUMO configuration.*my\.sumocfg"):
        settings(row_of(scenario, back))


def row_of(scenario, back):
    names = {"scenario": scenario.name, "run_id": "my-demand0.7-mine-zhao2025-p1-s3", "demand": 0.91}
    runs = {
        "strategy": "zhao2025", "sensing": "ideal", "parameters": "", "penetration": 1.0, "seed": 3, "begin_s": 30.0,
        "end_s": 30.4, "step_length_s": 0.1, "blockage_s": 60.0, "drivers": back.scenario.drivers.name,
        "ebike_share": None, "weather": "", "mu": 0.85,
    }  # fmt: skip
    return names | runs


def test_what_was_made_in_python_alone_does_not_come_back(on_track):
    with pytest.raises(InputError, match="unknown scenario 'test'"):
        settings(row(on_track(""), Equipment()))


def test_the_tables_of_the_second_run_are_those_of_the_first():
    scenario = scenarios.load("track").varied(weather="wet")
    first = run(scenario, equip=of("staged", **{"brake.lag": 0.1}), seed=5, duration=6.0, blockage=7.0)
    again = settings(first.runs.iloc[0])
    second = run(
        again.scenario, equip=again.equip, seed=again.seed, duration=again.duration, step_length=again.step_length,
        blockage=again.blockage,
    )  # fmt: skip
    assert len(first.crashes)
    for name in first.tables:
        pd.testing.assert_frame_equal(first.frame(name), second.frame(name))
