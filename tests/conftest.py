"""Shared by all tests."""

from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import settings

import sumo_nets
from aeb_sumo.drivers.profile import ROBOTS, Profile
from aeb_sumo.scenarios import Scenario

pytest_plugins = ["pytester"]

settings.register_profile("fixed", derandomize=True)
settings.load_profile("fixed")

BOLOGNA = Path(__file__).parents[2] / "shared" / "scenarios" / "bologna-acosta"


@pytest.fixture
def bologna() -> Path:
    """The real city; lies beside the project, not in it."""
    if not BOLOGNA.is_dir():
        pytest.skip(f"{BOLOGNA} is not there")
    return BOLOGNA


@pytest.fixture
def on_track(tmp_path: Path) -> Callable[..., Scenario]:
    """Makes a scenario on the straight track from vehicles in SUMO's XML, driven by robots unless told otherwise."""

    def make(vehicles: str, drivers: Profile = ROBOTS, **changes: object) -> Scenario:
        routes = tmp_path / "track.rou.xml"
        routes.write_text(
            '<routes><vType id="car" vClass="passenger" length="4.6" width="1.82" sigma="0" speedDev="0" '
            'lcSpeedGain="0" lcKeepRight="0" lcStrategic="-1"/><vType id="attentive" vClass="bus" length="4.6" '
            f'width="1.82" sigma="0" speedDev="0"/><route id="r" edges="track"/>{vehicles}</routes>'
        )
        net = sumo_nets.folder("track") / "track.net.xml"
        values: dict = {"duration": 30.0, "drivers": drivers} | changes
        return Scenario(name="test", options=("-n", str(net), "-r", str(routes)), **values)

    return make
