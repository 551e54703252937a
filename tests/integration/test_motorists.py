"""Drivers on the road: surprise, glances, warnings."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from aeb_sumo.criticality import ttc, ttc2
from aeb_sumo.drivers.encounters import Warned
from aeb_sumo.drivers.lapses import Glances, HardBraking
from aeb_sumo.drivers.profile import Profile
from aeb_sumo.drivers.reactions import Careful, Looming
from aeb_sumo.simulate import run
from aeb_sumo.strategies.base import Demand, Phase, Strategy
from aeb_sumo.trace import Trace
from tests.helpers import vehicle

STOP = '<stop lane="track_0" endPos="{}" duration="60"/>'
HARD = '<vType id="hard" vClass="passenger" length="4.6" decel="8" emergencyDecel="8" sigma="0" speedDev="0"/>'


@dataclass(frozen=True, kw_only=True)
class OnlyWarns(Strategy):
    """Warns below a TTC and never brakes."""

    name: ClassVar[str] = "only_warns"
    source: ClassVar[str] = "this test"
    ttc: float = 3.0

    def init(self, n):
        return Demand.nothing(n)

    def step(self, state, percept, dt):  # noqa: ARG002
        near = ttc(gap=percept.gap, closing_speed=percept.ego_speed - percept.target_speed) < self.ttc
        phase = np.where(percept.valid & near, int(Phase.WARN), int(Phase.NONE))
        return state, Demand(phase=phase, decel=np.zeros(len(phase)))


def follow(on_track, drivers, *, kind="hard", gap=30.0, strategy="none", duration=20.0):
    """A lead stops hard in front of a follower, both from 20 m/s."""
    lead = vehicle("lead", 604.6 + gap, 20.0, kind=kind, inside=STOP.format(604.6 + gap + 45))
    trace = Trace("ego", "lead")
    scenario = on_track(HARD + lead + vehicle("ego", 600, 20.0), drivers=drivers, duration=duration, step_length=0.05)
    result = run(scenario, strategy, trace=trace)
    rows = {name: part.set_index("time_s") for name, part in trace.frame().groupby("vehicle")}
    return result, rows["ego"], rows["lead"]


def test_a_careful_driver_reacts_to_hard_braking_as_un_r157_says(on_track):
    """He sees it at once, 0.75 s of reaction, then 12.65 m/s3 to 0.774 g; before that he goes on as he was."""
    careful = Careful()
    result, ego, lead = follow(on_track, Profile(cars=careful))
    assert len(result.crashes) == 0
    risk = (lead["accel_mps2"] < -careful.surprise).idxmax()
    waiting = ego.loc[risk + 0.05 : risk + careful.delay, "accel_mps2"]
    assert len(waiting) > 10
    assert np.ptp(waiting) < 0.05, "the acceleration is held"
    after = ego.loc[risk + careful.delay :, "accel_mps2"]
    assert after.min() == pytest.approx(-careful.decel, abs=0.05)
    reached = (after <= -careful.decel + 0.05).idxmax()
    assert reached - (risk + careful.delay) == pytest.approx(careful.decel / careful.jerk, abs=0.15)


def test_others_notice_that_the_vehicle_ahead_looms(on_track):
    """Inverse TTC of 0.2 1/s; until then the acceleration is held, to the moment at which alpha says."""
    looming = Looming(alpha_mean=0.2, alpha_sd=0.0)
    _, ego, lead = follow(on_track, Profile(cars=looming), gap=40.0)
    gap = lead["x_m"] - 4.6 - ego["x_m"]
    closing = ego["speed_mps"] - lead["speed_mps"]
    noticed = (closing / gap >= looming.looming).idxmax()
    surprised = (lead["accel_mps2"] < -looming.surprise).idxmax()
    assert noticed > surprised
    there = noticed
    crash_in = ttc2(
        gap=gap[there], closing_speed=closing[there], closing_accel=ego["accel_mps2"][there] - lead["accel_mps2"][there]
    )
    braking = (ego["accel_mps2"] < 0).loc[surprised:].idxmax()
    # A step until the state is seen, one until the command is executed, one until the jerk shows.
    assert 0 <= braking - (noticed + 0.2 * crash_in) <= 4 * 0.05


def test_sumos_own_drivers_react_at_once(on_track):
    _, ego, lead = follow(on_track, Profile())
    surprised = (lead["accel_mps2"] < -5).idxmax()
    assert (ego["accel_mps2"] < -2).idxmax() - surprised < 1.0


def test_who_brakes_gently_surprises_nobody(on_track):
    profile = Profile(cars=Careful())
    _, human, _ = follow(on_track, profile, kind="car")
    _, sumo, _ = follow(on_track, Profile(), kind="car")
    assert np.array_equal(human["accel_mps2"], sumo["accel_mps2"])


def test_a_glance_holds_the_acceleration_and_crashes_into_a_queue(on_track):
    """Eyes off the road for most of the time, calm or not."""
    blind = Glances(median=15.0, over_two=0.49, share=0.9, calm_ttc=0.0, calm_headway=0.0, calm_accel=99.0)
    result, ego, lead = follow(on_track, Profile(glances=blind, cars=Looming()), kind="car", gap=80.0, duration=30.0)
    (crash,) = result.crashes.itertuples()
    assert (crash.striker, crash.striker_error) == ("ego", "glance")
    assert lead.loc[crash.time_s :, "speed_mps"].max() == 0, (
        "the lead was at a scheduled stop, from which SUMO moves nobody"
    )
    assert result.runs["override_violations"].item() == 0
    before = ego.loc[crash.time_s - 2 : crash.time_s - 0.1, "accel_mps2"]
    assert np.ptp(before) < 1e-6


@pytest.mark.parametrize("responds", [0.0, 1.0])
def test_a_warned_driver_reacts_to_the_warning(on_track, responds):
    blind = Glances(median=15.0, over_two=0.49, share=0.9, calm_ttc=0.0, calm_headway=0.0, calm_accel=99.0)
    profile = Profile(glances=blind, cars=Careful(), warned=Warned(responds=responds, delay_mean=0.3, delay_sd=0.0))
    result, ego, _ = follow(on_track, profile, kind="car", gap=80.0, duration=30.0, strategy=OnlyWarns(ttc=4.0))
    assert (result.interventions["phase"] == "warn").all()
    assert len(result.crashes) == (0 if responds else 1)
    if responds:
        warned = (ego["phase"] >= Phase.WARN).idxmax()
        braking = (ego["accel_mps2"] < -1.0).loc[warned:].idxmax()
        assert 0.3 <= braking - warned <= 0.3 + 0.2, "the delay of the warning, not the reaction to what is seen late"


def test_who_notices_nothing_is_soon_himself_again(on_track):
    """A lead far ahead brakes hard for a moment: the driver behind is not held for longer than that."""
    push = HardBraking(every=8.0, decel=8.0, duration=0.5)
    _, ego, lead = follow(on_track, Profile(cars=Looming(), hard_braking=push), kind="car", gap=110.0, duration=30.0)
    assert (lead["accel_mps2"] < -5).any()
    ego_brakes = ego["accel_mps2"] < -5
    quiet = (ego["accel_mps2"].diff().abs() < 1e-9) & (ego["speed_mps"] > 1) & ~ego_brakes
    longest = quiet.groupby((~quiet).cumsum()).sum().max() * 0.05
    assert longest < 3.0


def test_the_reaction_ends_when_nothing_closes_in(on_track):
    """Afterwards SUMO's driver is back: he drives up to the lead and stops behind it."""
    _, ego, lead = follow(on_track, Profile(cars=Careful()), duration=40.0)
    gap = (lead["x_m"] - 4.6 - ego["x_m"]).iloc[-1]
    assert ego["speed_mps"].iloc[-1] == 0
    assert 0 < gap < 6
