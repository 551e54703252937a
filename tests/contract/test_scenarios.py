"""Laws that every registered scenario keeps."""

import pytest

from aeb_sumo import scenarios
from aeb_sumo.results import TABLES
from aeb_sumo.simulate import run


@pytest.fixture(params=scenarios.names(), scope="module")
def scenario(request):
    return scenarios.load(request.param)


@pytest.fixture(scope="module")
def pair(scenario):
    return {1.0: run(scenario, duration=30), "none": run(scenario, "none", duration=30)}


def test_tables_have_their_schema(pair):
    for name, table in TABLES.items():
        assert pair[1.0].tables[name].schema.equals(table.arrow(), check_metadata=True)


def test_every_command_is_executed(pair):
    for result in pair.values():
        assert result.runs["override_violations"].item() == 0


ZEROS = [
    {"penetration": 0.0},
    {"equip": "zhao2025=0"},
    {"equip": "zhao2025=0,zhao2025/radar=0,yan2025=0,lin2021=0,truck:staged=0"},
]


@pytest.mark.parametrize("nobody", ZEROS, ids=str)
def test_equipping_nobody_is_none(scenario, pair, nobody):
    """It changes nothing: only what `runs` says of the equipment differs."""
    zero, none = run(scenario, duration=30, **nobody), pair["none"]
    for name in TABLES:
        labels = ["run_id"] + (["strategy", "sensing", "penetration"] if name == "runs" else [])
        assert zero.frame(name).drop(columns=labels).equals(none.frame(name).drop(columns=labels)), name


def test_the_same_run_twice_is_the_same(scenario, pair):
    again = run(scenario, penetration=1.0, duration=30)
    for name in TABLES:
        assert again.tables[name].equals(pair[1.0].tables[name]), name


def test_cars_are_equipped(pair):
    exposure = pair[1.0].exposure
    assert exposure.loc[exposure["vclass"] == "passenger", "equipped"].all()
    assert not exposure.loc[exposure["vclass"] == "bicycle", "equipped"].any()
