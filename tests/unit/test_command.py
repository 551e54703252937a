import shlex
import subprocess
import sys

import pandas as pd
import pytest

from aeb_sumo import scenarios, strategies
from aeb_sumo.cli.run import run as run_command
from aeb_sumo.drivers import profile
from aeb_sumo.equipment import Equipment, equipment
from aeb_sumo.parameters import parse
from aeb_sumo.results import read
from aeb_sumo.results.command import arguments, shell
from aeb_sumo.simulate import run

BASE = {
    "run_id": "w0-zhao2025-p0.3-s2",
    "scenario": "w0",
    "strategy": "zhao2025",
    "sensing": "ideal",
    "parameters": "",
    "penetration": 0.3,
    "seed": 2,
    "drivers": "intersection",
    "step_length_s": 0.1,
    "begin_s": 0.0,
    "end_s": 0.1 * 3 + 600,
    "demand": 1.0,
    "ebike_share": 0.7,
    "weather": "",
    "mu": 0.85,
    "blockage_s": 60.0,
}


def parsed(row, **options):
    """What click makes of it, without what is not given."""
    words = arguments(row, **options)
    assert words[0] == "run"
    params = run_command.make_context("run", words[1:]).params
    return {k: v for k, v in params.items() if v not in (None, False, ()) and k != "interval"}


def test_a_run_parses_back_to_its_own_settings():
    assert parsed(BASE) == {
        "scenario": "w0", "strategy": "zhao2025", "sensing": "ideal", "penetration": 0.3, "seed": 2,
        "duration": 600.3, "step_length": 0.1, "blockage": 60.0,
    }  # fmt: skip
    assert "seed" not in parsed(BASE, seed=False)


def test_the_baseline_names_no_sensors():
    row = BASE | {"run_id": "w0-none-p0-s2", "strategy": "none", "sensing": "", "penetration": 0.0}
    assert parsed(row)["strategy"] == "none"
    assert not {"sensing", "penetration", "equip"} & set(parsed(row))


def test_what_a_run_was_told_is_told_again():
    told = {"demand": 1 / 3, "ebike_share": 0.5, "weather": "wet", "mu": 0.4, "drivers": "my/tired.toml"}
    row = BASE | told | {"run_id": "w0-demand0.333333-ebikes0.5-wet-mu0.4-tired-zhao2025-p0.3-s2"}
    assert told.items() <= parsed(row).items()
    # The same values as the scenario's own: nothing is named.
    assert not set(told) & set(parsed(BASE | told | {"run_id": "w0-zhao2025-p0.3-s2"}))


def test_a_demand_beside_a_scale_of_the_configuration_is_the_factor_alone():
    row = BASE | {"scenario": "my/city.sumocfg", "demand": 1.69, "run_id": "city-demand1.3-zhao2025-p0.3-s2"}
    assert parsed(row)["demand"] == 1.3
    assert str(parsed(row)["sumocfg"]) == "my/city.sumocfg"
    assert "scenario" not in parsed(row)


def test_parameters_come_back_as_they_were():
    row = BASE | {"parameters": "comfort_decel=5.0 brake.lag=1e-05 known_friction=True"}
    assert parse(parsed(row)["assignments"]) == {"comfort_decel": 5.0, "brake.lag": 1e-05, "known_friction": True}


def test_a_mix_comes_back_as_a_mix():
    carried = Equipment.parse("truck:zhao2025/radar=0.2,yan2025=0.1", {"yan2025.brake.lag": 0.2})
    row = BASE | {"strategy": carried.name, "sensing": carried.sensing, "parameters": carried.parameters}
    found = parsed(row)
    assert equipment(equip=Equipment.parse(found["equip"], parse(found["assignments"]))) == carried
    assert not {"strategy", "sensing", "penetration"} & set(found)


@pytest.mark.parametrize(
    ("scenario", "strategy", "parameters", "penetration"),
    [("track", "zhao2025", {"comfort_decel": 5.0}, 0.25), ("track", "none", {}, 1.0), ("w0", "staged", {}, 1 / 3)],
)
def test_the_line_in_a_shell_makes_the_same_tables(tmp_path, scenario, strategy, parameters, penetration):
    varied = scenarios.load(scenario).varied(weather="wet", drivers=profile.load("careful"))
    equip = Equipment.single(strategies.load(strategy, parameters), penetration=penetration)
    first = run(varied, equip=equip, seed=5, duration=4.0, blockage=7.0)
    line = shell(arguments(first.runs.iloc[0]))
    words = [sys.executable, "-m", "aeb_sumo", *shlex.split(line)[1:], "--out", str(tmp_path / "again"), "--quiet"]
    subprocess.run(words, check=True)
    again = read(tmp_path / "again")
    for name in first.tables:
        pd.testing.assert_frame_equal(first.frame(name), again.frame(name))
