"""Failure to yield and riding at red, at w0."""

import pytest

from aeb_sumo.drivers.encounters import FailureToYield, Riders
from aeb_sumo.drivers.profile import Profile
from aeb_sumo.scenarios import Scenario
from aeb_sumo.simulate import run
from aeb_sumo.trace import Trace
from sumo_nets import folder

TYPES = (
    '<vType id="car" vClass="passenger" length="4.6" width="1.82" sigma="0" speedDev="0"/>'
    '<vType id="bike" vClass="bicycle" length="1.8" width="0.7" maxSpeed="5" sigma="0" speedDev="0"/>'
    '<route id="left" edges="si wo"/><route id="on" edges="ni so"/><route id="across" edges="wi eo"/>'
)
LEFT = '<vehicle id="car" type="car" route="left" depart="0" departLane="1" departPos="170" departSpeed="10"/>'
ONCOMING = '<vehicle id="bike" type="bike" route="on" depart="0" departLane="0" departPos="214" departSpeed="5"/>'
ACROSS = '<vehicle id="bike" type="bike" route="across" depart="0" departLane="0" departPos="200" departSpeed="5"/>'


def at_w0(vehicles, **errors):
    net = folder("w0") / "w0.net.xml"
    scenario = Scenario(
        name="w0",
        options=("-n", str(net)),
        routes=f"<routes>{TYPES}{vehicles}</routes>",
        drivers=Profile(**errors),
        duration=30,
    )
    trace = Trace("bike")
    return run(scenario, "none", trace=trace), trace.frame()


@pytest.mark.parametrize(("driver", "rider", "crashes"), [(1.0, 1.0, 1), (0.0, 1.0, 0), (0.0, 0.0, 0)])
def test_it_takes_two(driver, rider, crashes):
    """A driver who does not look and a rider who relies on his right of way; a driver who looks is enough."""
    result, _ = at_w0(LEFT + ONCOMING, failure_to_yield=FailureToYield(probability=driver, rider_unaware=rider))
    assert len(result.crashes) == crashes
    if crashes:
        errors = result.crashes.iloc[0][["striker_error", "struck_error"]]
        assert "failure_to_yield" in set(errors)


@pytest.mark.parametrize("probability", [0.0, 1.0])
def test_a_rider_at_red(probability):
    """The east-west road has red at first; who does not stop rides through, where there is nobody in the way."""
    _, bike = at_w0(ACROSS, riders=Riders(red_light=probability))
    stopped = (bike["speed_mps"] < 0.1).any()
    assert stopped == (probability == 0.0)
    assert (bike["x_m"].max() > 0) == (probability == 1.0)
