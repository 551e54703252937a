"""Scenarios of single accident types produce them."""

import pytest

from aeb_sumo import scenarios
from aeb_sumo.simulate import run


@pytest.mark.slow
@pytest.mark.parametrize("name", ["221", "321", "322", "601"])
def test_without_aeb_the_scenario_has_crashes_of_its_type(name):
    crashes = run(scenarios.load(name), "none").crashes
    assert (crashes["typology"] == name).sum() >= 1
    others = set(crashes.loc[crashes["typology"] != "", "typology"]) - {name}
    assert not others
