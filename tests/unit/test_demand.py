"""Traffic from parameters."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aeb_sumo import scenarios
from aeb_sumo.drivers import profile
from aeb_sumo.errors import InputError
from aeb_sumo.scenarios.demand import Demand, Rider, routes
from sumo_nets.intersection import Intersection

FOUR, THREE = Intersection(contraflow=True), Intersection(arms="nsw", contraflow=True)
shares = st.floats(0.01, 0.33)


@given(st.sampled_from([FOUR, THREE]), st.floats(100, 5000), st.floats(0, 1), shares, shares, shares, st.floats(0, 1))
def test_flows_add_up_to_the_demand(it, flow, ebikes, left, right, against, main):
    demand = Demand(
        flow=flow, ebike_share=ebikes, left=left, right=right, rider_left=left, rider_right=right, against=against,
        main_share=main,
    )  # fmt: skip
    flows = demand.flows(it)
    assert sum(rate for _, _, rate in flows.values()) * 3600 == pytest.approx(flow)
    assert sum(rate for kind, _, rate in flows.values() if kind == "ebike") * 3600 == pytest.approx(flow * ebikes)


def test_shares_of_movements_are_those_asked_for():
    flows = Demand(flow=3600, ebike_share=0, left=0.5, right=0.2, main_share=1.0).flows(FOUR)
    rates = {name: rate for name, (_, _, rate) in flows.items()}
    assert rates == pytest.approx(
        {"car_sw": 0.25, "car_sn": 0.15, "car_se": 0.1, "car_ne": 0.25, "car_ns": 0.15, "car_nw": 0.1}
    )


def test_riders_who_turn_left_in_two_stages_pass_by_their_waiting_area():
    assert Demand().flows(FOUR)["ebike_sw"][1] == ("si", "slo", "sli", "wo")
    assert Demand().flows(THREE)["ebike_wn"][1] == ("wi", "no")  # nobody comes towards them


def test_speeds_of_riders_have_the_mean_and_spread_asked_for_below_the_limit():
    speeds = np.array(Rider(max_speed=30.0).speeds()) * 3.6
    assert speeds.mean() == pytest.approx(17.1, abs=0.1)
    assert speeds.std() == pytest.approx(3.5, abs=0.3)
    assert np.median(speeds) < speeds.mean()  # log-normal: skewed to the right
    assert max(Rider().speeds()) * 3.6 <= 25.0 + 1e-9


def test_the_same_parameters_give_the_same_text():
    assert routes(FOUR, Demand()) == routes(Intersection(contraflow=True), Demand())


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"ebike_share": 1.2}, r"Demand.ebike_share must be within 0 .. 1, not 1.2"),
        ({"flow": -5.0}, r"Demand.flow must be within 0 .. 20000, not -5"),
        ({"left": 0.8, "right": 0.3}, r"left \+ right must be 1 or less, not 1.1"),
        ({"rider_left": 0.8, "against": 0.3}, r"rider_left \+ rider_right \+ against must be 1 or less, not 1.2"),
    ],
)
def test_demand_that_cannot_be_is_named(values, message):
    with pytest.raises(InputError, match=message):
        Demand(**values)


def test_a_scenario_varied():
    w0 = scenarios.load("w0")
    changed = w0.varied(demand=2.0, ebike_share=0.25, weather="wet")
    assert (changed.factor, changed.demand.ebike_share, changed.weather, changed.mu) == (2.0, 0.25, "wet", 0.5)
    assert w0.varied(weather="wet", mu=0.3).mu == 0.3
    assert changed.vehicles == routes(changed.intersection, Demand(flow=2 * Demand().flow, ebike_share=0.25))
    assert w0.varied() == w0


def test_other_scenarios_are_scaled_by_sumo():
    highway = scenarios.load("highway").varied(demand=0.5)
    assert highway.sumo_options[-2:] == ("--scale", "0.5")
    assert "--scale" not in scenarios.load("highway").sumo_options
    halved = replace(scenarios.load("highway"), scale=2.0).varied(demand=0.5)
    assert halved.sumo_options[-2:] == ("--scale", "1"), "also where that undoes the scenario's own factor"


def test_what_was_varied_is_in_the_name_of_a_run():
    varied = scenarios.load("w0").varied(demand=0.5, mu=0.3, drivers=profile.load("careful"))
    assert varied.variation == "demand0.5-mu0.3-careful"
    assert scenarios.load("w0").variation == ""


def test_robots_have_no_demand():
    with pytest.raises(InputError, match="track has no flows for a demand to multiply"):
        scenarios.load("track").varied(demand=2.0)


@pytest.mark.parametrize(
    ("name", "variation", "message"),
    [
        ("highway", {"ebike_share": 0.5}, "highway has no share of e-bikes to set; these have: b2, w0, w1, w2, w2t"),
        ("w0", {"ebike_share": 1.5}, "Demand.ebike_share must be within 0 .. 1, not 1.5"),
        ("w0", {"demand": 0.0}, "demand must be a positive factor, not 0"),
        ("w0", {"demand": float("nan")}, "demand must be a positive factor, not nan"),
        ("w0", {"weather": "snow"}, "weather must be one of dry, wet, not 'snow'"),
        ("w0", {"mu": 7.0}, "friction of w0 must be within"),
    ],
)
def test_a_variation_that_cannot_be_is_named(name, variation, message):
    with pytest.raises(InputError, match=message):
        scenarios.load(name).varied(**variation)
