"""Friction is a property of the road, read by the plant; what a vehicle knows of it is another matter."""

import numpy as np
import pytest

from aeb_sumo import scenarios, strategies
from aeb_sumo.errors import InputError
from aeb_sumo.scenarios.cases import EGO, START, approach
from aeb_sumo.simulate import run
from aeb_sumo.trace import Trace
from aeb_sumo.units import G
from aeb_sumo.world.friction import Stretch


def braking(strategy="lin2021", **where):
    """An ego that brakes with 3 m/s2 across a joint from mu 0.8 to 0.5, 30 m down the road; columns of its trace."""
    trace = Trace(EGO)
    joint = Stretch(road="track", mu=0.5, start=START + 30) if not where else Stretch(**where)
    road = approach(
        "joint", ego=20.0, lead=25.0, gap=50.0, mu=0.8, stretches=(joint,), ego_braking=(0.5, 3.0), duration=5.0
    )
    run(road, strategy, trace=trace)
    return trace.frame()


def test_the_plant_reads_the_road_under_each_vehicle():
    frame = braking()
    behind = frame["x_m"] >= START + 30
    assert (frame.loc[behind, "mu"] == 0.5).all()
    assert (frame.loc[~behind, "mu"] == 0.8).all()
    assert behind.any()
    assert not behind.all()


def test_by_edge_or_lane():
    assert (braking(road="track_1", mu=0.5)["mu"] == 0.8).all(), "the ego drives on track_0"
    assert (braking(road="track_0", mu=0.5)["mu"] == 0.5).all()


def test_the_estimate_runs_behind_the_truth_and_catches_up():
    """L14: within 0.05 of the new friction 0.2 s behind the joint."""
    frame = braking()
    joint = frame.loc[frame["mu"] == 0.5, "time_s"].iloc[0]
    error = (frame["mu_known"] - frame["mu"]).abs()
    assert error[frame["time_s"].between(1.0, joint - 0.05)].max() < 0.05
    assert error[frame["time_s"] == joint].item() > 0.05, "it cannot know at once"
    assert error[frame["time_s"] > joint + 0.2].max() < 0.05


def test_others_are_told_the_truth():
    frame = braking("zhao2025")
    assert (frame["mu_known"] == frame["mu"]).all()


def test_a_wrong_prior_is_corrected_by_braking():
    """It enters with 0.8 on a road of 0.4: right within 0.2 s of braking, and not before."""
    trace = Trace(EGO)
    road = approach("wet", ego=20.0, lead=25.0, gap=50.0, mu=0.4, ego_braking=(0.5, 3.0), duration=3.0)
    run(road, strategies.load("lin2021", {"knows_road": False}), trace=trace)
    frame = trace.frame()
    frame["time_s"] -= frame["time_s"].iloc[0]
    assert (frame.loc[frame["time_s"] < 0.5, "mu_known"] - 0.8).abs().max() < 0.01
    assert (frame.loc[frame["time_s"] > 0.75, "mu_known"] - 0.4).abs().max() < 0.05


def test_others_without_an_aeb_are_traced_too():
    trace = Trace()
    run(scenarios.load("w0"), "lin2021", penetration=0.5, duration=30, trace=trace)
    frame = trace.frame()
    bikes = frame["vehicle"].str.startswith("ebike")
    assert frame.loc[bikes, "mu_known"].isna().all()
    assert frame.loc[~bikes, "mu_known"].notna().any()


def test_without_braking_nothing_is_learned():
    trace = Trace(EGO)
    joint = Stretch(road="track", mu=0.5, start=START + 30)
    run(
        approach("joint", ego=20.0, lead=25.0, gap=50.0, mu=0.8, stretches=(joint,), duration=5.0),
        "lin2021",
        trace=trace,
    )
    assert np.abs(trace.frame()["mu_known"] - 0.8).max() < 0.01


def test_no_brake_exceeds_the_friction_of_its_place():
    trace = Trace(EGO)
    ice = Stretch(road="track", mu=0.2, start=START + 20)
    run(approach("ice", ego=15.0, lead=15.0, gap=60.0, stretches=(ice,), ego_braking=(0.1, 6.0)), "none", trace=trace)
    frame = trace.frame().iloc[:200]
    on_ice = frame["x_m"].shift() > START + 20
    assert (-frame.loc[~on_ice, "accel_mps2"]).max() == pytest.approx(6.0)
    assert (-frame.loc[on_ice, "accel_mps2"]).max() == pytest.approx(0.2 * G)


@pytest.mark.parametrize(
    ("where", "message"),
    [
        ({"road": "nowhere", "mu": 0.5}, "the network has no edge or lane 'nowhere'"),
        ({"road": "track", "mu": -0.5}, "friction of track must be within 0.05 .. 1.5, not -0.5"),
        ({"road": "track", "mu": 0.5, "start": 20.0, "end": 10.0}, "from 20 to 10 m is no stretch of road"),
    ],
)
def test_bad_stretches(where, message):
    with pytest.raises(InputError, match=message):
        braking(**where)
