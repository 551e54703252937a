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
ONCOMING = '<vehicle id="bike" type="bike" route="on" depart="0" departLane="0" departPos="208" departSpeed="5"/>'
ACROSS = '<vehicle id="bike" type="bike" route="across" depart="0" departLane="0" departPos="200" departSpeed="5"/>'


def at_w0(vehicles, *, duration=30, blockage=None, **errors):
    net = folder("w0") / "w0.net.xml"
    scenario = Scenario(
        name="w0",
        options=("-n", str(net)),
        routes=f"<routes>{TYPES}{vehicles}</routes>",
        drivers=Profile(**errors),
        duration=duration,
    )
    trace = Trace("bike")
    return run(scenario, "none", trace=trace, blockage=blockage), trace.frame()


@pytest.mark.parametrize(("driver", "rider", "crashes"), [(1.0, 1.0, 1), (1.0, 0.0, 0), (0.0, 1.0, 0)])
def test_it_takes_two(driver, rider, crashes):
    """A driver who does not look and a rider who relies on his right of way; one who looks is enough."""
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


@pytest.mark.parametrize("names", [("car", "bike"), ("a", "z"), ("z", "a")], ids="/".join)
def test_both_may_leave_in_the_same_step(names):
    """As the wrecks of one crash do."""
    vehicles = (LEFT + ONCOMING).replace('id="car"', f'id="{names[0]}"').replace('id="bike"', f'id="{names[1]}"')
    always = FailureToYield(probability=1.0, rider_unaware=1.0)
    result, _ = at_w0(vehicles, duration=60, blockage=3.0, failure_to_yield=always)
    assert len(result.crashes) == 1
    assert result.runs["outcome"].item() == "completed"


def test_nobody_is_overlooked_behind_the_junction(monkeypatch):
    """Whoever is hidden from somebody is so until one of them is through."""
    from aeb_sumo.world import violations

    hidden: dict[str, set[str]] = {}
    monkeypatch.setattr(violations, "overlook", lambda who, whom: hidden.__setitem__(who, set(whom)))
    at_w0(LEFT + ONCOMING.replace('departPos="208"', 'departPos="180"'), duration=40,
          failure_to_yield=FailureToYield(probability=1.0, rider_unaware=1.0))  # fmt: skip
    assert hidden, "they did meet"
    assert not any(hidden.values())
