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
    return {p: run(scenario, penetration=p, duration=40) for p in (0.0, 1.0)} | {
        "none": run(scenario, "none", duration=40)
    }


def test_tables_have_their_schema(pair):
    for name, table in TABLES.items():
        assert pair[1.0].tables[name].schema.equals(table.arrow(), check_metadata=True)


def test_every_command_is_executed(pair):
    for result in pair.values():
        assert result.runs["override_violations"].item() == 0


def test_penetration_0_is_none(pair):
    """Equipping nobody changes nothing: only the labels differ."""
    for name in TABLES:
        zero, none = (
            r.frame(name).drop(columns=["run_id", "strategy", "sensing", "penetration"], errors="ignore")
            for r in (pair[0.0], pair["none"])
        )
        assert zero.equals(none), name


def test_the_same_run_twice_is_the_same(scenario, pair):
    again = run(scenario, penetration=1.0, duration=40)
    for name in TABLES:
        assert again.tables[name].equals(pair[1.0].tables[name]), name


def test_cars_are_equipped(pair):
    exposure = pair[1.0].exposure
    assert exposure.loc[exposure["vclass"] == "passenger", "equipped"].all()
    assert not exposure.loc[exposure["vclass"] == "bicycle", "equipped"].any()
