"""A system at work keeps its target, and a lead that brakes hard is watched at once."""

import numpy as np
import pytest

from aeb_sumo.drive import Case, drive
from aeb_sumo.scenarios.cases import approach
from aeb_sumo.strategies import load
from aeb_sumo.strategies.base import Phase
from aeb_sumo.units import KMH


@pytest.mark.parametrize(
    ("strategy", "ego", "lead"),
    [("lin2021", 100, 0), ("lin2021_fixed", 100, 0), ("lin2021_fixed", 100, 50), ("perfect", 50, 25)],
)
def test_it_brakes_until_nothing_closes_in_any_more(strategy, ego, lead):
    law = load(strategy)
    gap = 4.0 * ego * KMH if lead else 8.0 * ego * KMH
    case = approach("ccrm", ego=ego * KMH, lead=lead * KMH, gap=gap, step_length=0.1, duration=20.0)
    d = drive(Case(scenario=case, strategy=law, sensing=law.sensing))
    braking = d.ego["phase"].to_numpy() >= Phase.PARTIAL_BRAKE
    over = np.argmax((np.arange(len(braking)) > d.triggered) & (d.closing <= 0.3))
    assert not d.crashed
    assert over > d.triggered >= 0
    assert braking[d.triggered : over].all()


@pytest.mark.parametrize(("speed", "decel"), [(80, 8.0), (110, 2.6)], ids=["commanded in every step", "once"])
@pytest.mark.parametrize("headway", [0.8, 1.0, 1.2, 1.4])
@pytest.mark.parametrize("begin", [2.0, 2.1, 2.2])
def test_a_lead_that_brakes_hard_is_a_target_at_once_and_stays_one(speed, decel, headway, begin):
    case = approach(
        "ccrb", ego=speed * KMH, lead=speed * KMH, gap=headway * speed * KMH, braking=(begin, decel), step_length=0.1,
        duration=6.0,
    )  # fmt: skip
    d = drive(Case(scenario=case, strategy=load("zhao2025"), sensing="ideal"))
    target, brakes = d.ego["target"].to_numpy() != "", d.target["accel_mps2"].to_numpy() < -decel / 2
    assert brakes.any()
    early = d.ego["time_s"].to_numpy() < begin + 2.0  # later it may be too late
    assert target[brakes & early].all()
