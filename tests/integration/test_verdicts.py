"""Every intervention against a fork of the world in which it does not take place."""

import os
import signal
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest

from aeb_sumo import scenarios, strategies
from aeb_sumo.results import TABLES
from aeb_sumo.scenarios import from_sumocfg
from aeb_sumo.simulate import run
from aeb_sumo.verdicts import Verdicts
from tests.helpers import approach, vehicle

JUDGED = [c.name for c in TABLES["interventions"].columns]
JUDGED = JUDGED[JUDGED.index("verdict") :]


def factual(result, table):
    return result.tables[table].drop_columns(JUDGED) if table == "interventions" else result.tables[table]


def judged(scenario, strategy="zhao2025", **options):
    return run(scenario, strategy, verdicts="all", **options).interventions


@pytest.mark.parametrize(("name", "duration"), [("highway", 60), ("w0", 90), ("221", 60)])
def test_a_run_with_verdicts_has_the_same_tables_as_one_without(name, duration):
    scenario = scenarios.load(name)
    with_, without = (run(scenario, "zhao2025", duration=duration, verdicts=v) for v in ("all", "none"))
    assert len(with_.interventions) > 1
    for table in TABLES:
        assert factual(with_, table).equals(factual(without, table)), table
    assert (with_.interventions["verdict"] != "").all()
    assert (with_.interventions["verdict"] != "unknown").all()
    assert (without.interventions["verdict"] == "").all()
    assert without.interventions["with_crash"].isna().all()


def test_a_city_with_verdicts_is_the_same_city(bologna, tmp_path):
    scenario = from_sumocfg(bologna / "run.sumocfg")
    results = {}
    for verdicts in ("all", "none"):
        (tmp_path / verdicts).mkdir()
        results[verdicts] = run(
            scenario, "zhao2025", duration=90, step_length=0.2, verdicts=verdicts, sumo_output=tmp_path / verdicts
        )
    assert len(results["all"].interventions) > 20
    for table in TABLES:
        assert factual(results["all"], table).equals(factual(results["none"], table)), table
    trips = [(tmp_path / v / "tripinfos.xml").read_text().partition("-->")[2] for v in results]
    assert trips[0] == trips[1]


def test_an_aeb_that_stops_behind_a_standing_car_has_avoided_the_crash(on_track):
    (one,) = judged(on_track(approach(40, 0, 50))).to_dict("records")
    crash = run(on_track(approach(40, 0, 50)), "none").crashes.iloc[0]
    assert one["verdict"] == "avoided"
    assert (one["with_crash"], one["without_crash"]) == (False, True)
    assert one["without_impact_speed_mps"] == pytest.approx(crash["impact_speed_mps"])
    assert one["without_serious_risk"] == pytest.approx(crash["struck_serious_risk"])
    assert one["without_delta_v_mps"] == pytest.approx(crash[["striker_delta_v_mps", "struck_delta_v_mps"]].max())
    assert one["acted_by"] == "brake"
    assert one["acted_s"] >= one["brake_s"]
    assert one["without_min_gap_m"] == 0 < one["with_min_gap_m"]


def test_an_aeb_that_brakes_too_late_has_mitigated_it(on_track):
    (one,) = judged(on_track(approach(72, 0, 60)), "staged").to_dict("records")
    assert one["verdict"] == "mitigated"
    assert 0 < one["with_impact_speed_mps"] < one["without_impact_speed_mps"]
    assert one["with_serious_risk"] < one["without_serious_risk"]


def threshold(ttc):
    """An AEB that brakes at a TTC."""
    return strategies.load("staged", {"warn_ttc": ttc, "brake_ttc": ttc})


def test_a_brake_that_gets_its_car_hit_from_behind_has_induced_a_crash(on_track):
    """The slower car ahead leaves the road in good time, but the AEB has braked, and the one behind does not look."""
    scene = vehicle("lead", 640, 14.0).replace('id="lead"', 'id="lead" arrivalPos="668"')
    scene += vehicle("ego", 600, 20.0) + vehicle("behind", 590, 20.0, kind="attentive")
    (one,) = judged(on_track(scene), threshold(6.0), duration=12).to_dict("records")
    assert one["verdict"] == "induced"
    assert (one["with_crash"], one["without_crash"]) == (True, False)
    assert one["with_impact_speed_mps"] > 3
    assert one["with_follower_decel_mps2"] < 10, "the crash itself is no braking"


def test_forking_when_it_acts_gives_what_forking_at_its_beginning_gives(monkeypatch):
    lazily = judged(scenarios.load("highway"), seed=6, duration=105)
    eager = lambda *args, **kind: Verdicts(*args, **kind, lazy=False)  # noqa: E731
    monkeypatch.setattr("aeb_sumo.simulate.Verdicts", eager)
    at_once = judged(scenarios.load("highway"), seed=6, duration=105)
    assert set(lazily["acted_by"]) >= {"brake", "warning"}
    assert (lazily["acted_s"] > lazily["begin_s"]).any()
    lately = ["acted_by", "acted_s"]
    pd.testing.assert_frame_equal(lazily.drop(columns=lately), at_once.drop(columns=lately))


def test_forks_that_may_not_sleep_give_what_sleeping_ones_give(monkeypatch):
    sleeping = judged(scenarios.load("highway"), seed=6, duration=80)
    monkeypatch.setattr("aeb_sumo.verdicts.book.SLEEPERS", 0)
    pd.testing.assert_frame_equal(judged(scenarios.load("highway"), seed=6, duration=80), sleeping)
    assert "warning" in set(sleeping["acted_by"])


def test_a_window_that_the_run_does_not_live_to_see_is_seen_by_a_fork():
    """Verdicts do not depend on when the run ends."""
    short, long = (judged(scenarios.load("highway"), threshold(6.0), duration=d) for d in (36, 46))
    both = short[short["end_s"] < 34].merge(long, on=["vehicle", "begin_s"], suffixes=("", "_long"))
    assert (both["begin_s"] > 26).sum() > 1
    for column in JUDGED:
        pd.testing.assert_series_equal(both[column], both[f"{column}_long"], check_names=False)


def test_a_sample_is_a_part_of_all():
    every, some = (
        run(scenarios.load("highway"), threshold(6.0), duration=34, verdicts=v).interventions
        for v in ("all", "sample:3")
    )
    chosen = some["verdict"] != ""
    assert chosen.sum() == 3 < len(some)
    pd.testing.assert_frame_equal(some[chosen], every[chosen], check_dtype=False)  # null makes bools objects
    assert some.loc[~chosen, "without_crash"].isna().all()


def test_a_fork_that_dies_gives_unknown_and_the_run_goes_on(monkeypatch):
    def dies(self, watch, slot):
        os.kill(os.getpid(), signal.SIGKILL)

    monkeypatch.setattr(Verdicts, "_otherwise", dies)
    result = run(scenarios.load("highway"), "zhao2025", duration=60, verdicts="all")
    forked = result.interventions[result.interventions["verdict"] == "unknown"]
    assert len(forked) > 1
    assert set(forked["verdict_reason"]) == {"the fork was ended by signal 9"}
    assert forked["without_crash"].isna().all()
    assert forked["with_crash"].notna().all()
    assert result.runs["outcome"].iloc[0] == "completed"


def test_where_the_world_cannot_be_forked_the_verdict_is_unknown_and_says_why(on_track):
    scenario = on_track(approach(40, 0, 50))
    scenario = replace(scenario, options=(*scenario.options, "--device.rerouting.threads", "2"))
    (one,) = judged(scenario).to_dict("records")
    assert one["verdict"] == "unknown"
    assert one["verdict_reason"] == "SUMO runs with 2 device.rerouting.threads, and a world is forked with one only"


def test_an_interrupted_run_leaves_its_open_verdicts_unknown():
    steps = iter(range(10_000))
    found = judged(scenarios.load("highway"), threshold(6.0), duration=60, stop=lambda: next(steps) == 419)
    reasons = found.set_index("begin_s")["verdict_reason"]
    assert set(reasons) == {"", "the run was interrupted"}
    assert (reasons[reasons.index > 33] != "").all()
    assert (found["verdict"] == "unknown").equals(found["verdict_reason"] != "")


@pytest.fixture
def nobody_is_left():
    """Afterwards there are no more child processes than before."""
    before = children()
    yield
    assert children() <= before


def children():
    return {one for task in Path("/proc/self/task").iterdir() for one in (task / "children").read_text().split()}


def test_who_loses_his_place_in_the_sample_leaves_no_fork_behind(nobody_is_left):
    early = strategies.load("staged", {"warn_ttc": 6.0, "brake_ttc": 1.0})
    verdicts = run(scenarios.load("highway"), early, duration=40, verdicts="sample:1").interventions["verdict"]
    assert (verdicts != "").sum() == 1 < len(verdicts)


class Fails:
    """Looks on until an AEB has been braking for a step, and fails."""

    def attend(self, world):
        self.world, self.braked = world, False

    def step(self, time):
        if self.braked:
            raise ValueError(time)
        self.braked = bool((self.world.fleet.decel > 0).any())


def test_a_run_that_is_left_by_an_exception_leaves_no_fork_behind(nobody_is_left, on_track):
    with pytest.raises(ValueError, match=r"^\d"):
        judged(on_track(approach(40, 0, 50)), trace=Fails())


def test_a_window_that_nobody_has_seen_to_its_end_gives_unknown(monkeypatch, on_track):
    """It was cut short by the end of the run, and the fork that was to see the rest has died."""
    end, look = 3.5, Verdicts._outlook

    def dies_late(self, watches):
        if self._engine.time > end - 0.05:
            os.kill(os.getpid(), signal.SIGKILL)
        return look(self, watches)

    scenario = on_track(approach(40, 0, 50), duration=end)
    (one,) = judged(scenario).to_dict("records")
    assert one["verdict"] == "avoided"
    assert one["acted_s"] < end - 0.05
    monkeypatch.setattr(Verdicts, "_outlook", dies_late)
    (one,) = judged(scenario).to_dict("records")
    assert (one["verdict"], one["verdict_reason"]) == ("unknown", "the fork was ended by signal 9")


class Withholds:
    """What a system that wants to brake is left, by how long ago [s] it last acted."""

    def __init__(self, *ago):
        self.ago, self.left = ago, {}

    def attend(self, world):
        self.world = world

    def step(self, time):
        for ago in self.ago:
            self.world.fleet.decel[0] = 5.0
            self.world.fleet.withhold(0, time, time - ago)
            self.left[ago] = float(self.world.fleet.decel[0])


def test_an_intervention_after_a_pause_is_another_one_and_not_withheld(on_track):
    trace = Withholds(0.0, 0.9, 1.1, 3.0)
    run(on_track(vehicle("ego", 100, 20)), "zhao2025", duration=0.3, trace=trace)
    assert trace.left == {0.0: 0.0, 0.9: 0.0, 1.1: 5.0, 3.0: 5.0}


@pytest.mark.slow
def test_an_absurd_threshold_is_mostly_unneeded_and_a_very_short_one_never():
    """In a tenth of the cars: where all have the absurd one, its braking is a danger to those behind."""
    absurd, short = (
        judged(scenarios.load("highway"), threshold(ttc), sensing="ideal", penetration=0.1, duration=330, seed=2)
        for ttc in (6.0, 0.3)
    )
    counts = absurd["verdict"].value_counts()
    assert counts.sum() > 20
    assert counts["unneeded"] > 0.5 * counts.sum()
    assert "unneeded" not in set(short["verdict"])
