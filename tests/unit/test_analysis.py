from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.stats import chi2

import analysis
from aeb_sumo.results import Results


@pytest.fixture
def data():
    """Two seeds without AEB, two with it: 3 + 1 crashes against 1 + 0, 1,000 km each."""
    runs, crashes, exposure, traffic = [], [], [], []
    for run, count in (("none-0", 3), ("none-1", 1), ("zhao2025-0", 1), ("zhao2025-1", 0)):
        strategy, one = run.partition("-")[0], {"run_id": run}
        runs.append(one | {"scenario": "s", "strategy": strategy, "penetration": 1.0, "begin_s": 0.0, "end_s": 1800.0})
        runs[-1] |= {"sumo_collisions": count, "confirmed_by_sumo": count}
        crash = one | {"kind": "rear_end", "impact_speed_mps": 5.0}
        crashes += [crash | {"secondary": k > 0} for k in range(count)]
        exposure.append(one | {"vclass": "passenger", "equipped": strategy != "none", "vehicles": 10})
        exposure[-1]["strategy"] = strategy.replace("none", "")
        exposure[-1] |= {"distance_m": 1e6, "time_s": 1e5}
        half = one | {"vclass": "passenger", "arrived": 50, "pending": 2}
        half |= {"distance_m": 5e5, "time_s": 5e4, "delay_s": 1e3}
        traffic += [half | {"begin_s": 900.0 * k, "end_s": 900.0 * (k + 1)} for k in (0, 1)]
    action = {
        "run_id": "zhao2025-0",
        "strategy": "zhao2025",
        "target_kind": "lead",
        "max_decel_mps2": 6.0,
        "speed_reduction_mps": 10.0,
    }
    interventions = [
        action | {"phase": "partial_brake", "trigger_ttc_s": 1.0},
        action | {"phase": "partial_brake", "trigger_ttc_s": np.inf},
        action | {"phase": "warn", "trigger_ttc_s": None},
    ]
    tables = {
        "runs": runs,
        "crashes": crashes,
        "interventions": interventions,
        "exposure": exposure,
        "traffic": traffic,
    }
    return analysis.Dataset.of(Results.of(tables))


def test_poisson_interval_is_garwoods():
    rate = analysis.poisson_rate(7, 2.0)
    assert (rate.rate, rate.low, rate.high) == pytest.approx((3.5, chi2.ppf(0.025, 14) / 4, chi2.ppf(0.975, 16) / 4))
    assert analysis.poisson_rate(0, 1.0).low == 0
    assert np.isnan(analysis.poisson_rate(0, 0.0).rate)
    with pytest.raises(ValueError, match="count -1"):
        analysis.poisson_rate(-1, 1.0)


def test_crash_counts_and_rates(data):
    assert analysis.crash_counts(data).loc["total"].to_dict() == {"none": 4, "zhao2025": 1}
    rates = analysis.crash_rates(data)
    assert rates.loc["none", "per_million_km"] == pytest.approx(2000)
    assert rates.loc["zhao2025", "low"] < 500 < rates.loc["zhao2025", "high"]


def test_interventions(data):
    assert analysis.intervention_counts(data)["zhao2025"].to_dict() == {"partial_brake": 2, "warn": 1}
    row = analysis.intervention_statistics(data).loc[("zhao2025", "zhao2025", "partial_brake", "lead")]
    assert row["per_1000_km"] == pytest.approx(1.0)
    assert row["trigger_ttc_s_mean"] == 1.0, "an infinite TTC does not count"


def test_throughput(data):
    row = analysis.throughput(data).loc["none"]
    assert row.to_dict() == pytest.approx(
        {"arrived": 200, "pending": 4, "flow_vph": 200, "speed_kmh": 36, "delay_s_per_km": 2}
    )
    assert (analysis.throughput_impact(data).loc["zhao2025"] == 0).all()


def test_summary_puts_the_baseline_first_and_the_difference_last(data):
    table = analysis.summary(data)
    assert list(table.columns) == ["none", "zhao2025", "difference"]
    assert table.loc[("crashes", "crashes", ""), "difference"] == -3
    assert isinstance(table, pd.DataFrame)


def test_compare_names_every_group(data):
    baseline = data.by_group()["none"]
    table = analysis.compare(A=baseline, B=data.by_group()["zhao2025"])
    assert list(table.columns) == ["A: none", "B: zhao2025", "difference"]


def test_runs_of_different_settings_are_different_groups(data):
    runs = data.runs.assign(mu=[0.85, 0.5, 0.85, 0.85])
    groups = replace(data, runs=runs).groups()
    assert groups.tolist() == ["none, mu 0.85", "none, mu 0.5", "zhao2025, mu 0.85", "zhao2025, mu 0.85"]


def test_what_differs_between_scenarios_alone_is_said_by_their_names(data):
    runs = data.runs.assign(
        scenario=["a", "b", "a", "b"], ebike_share=[np.nan, 0.7, np.nan, 0.7], drivers=["x", "y"] * 2
    )
    groups = replace(data, runs=runs).groups()
    assert groups.tolist() == [f"{who}, scenario {where}" for who in ("none", "zhao2025") for where in ("a", "b")]
    groups = replace(data, runs=runs.assign(mu=[0.5, 0.5, 0.85, 0.5])).groups()
    assert groups.tolist() == [
        "none, scenario a, mu 0.5", "none, scenario b", "zhao2025, scenario a, mu 0.85", "zhao2025, scenario b",
    ]  # fmt: skip


def conflicts(*rows):
    """(kind, near_crash, crashed, secondary, TTC, PET) each, and one primary and one secondary rear-end crash."""
    names = ("kind", "near_crash", "crashed", "secondary", "min_ttc_s", "pet_s")
    runs = [{"run_id": "a", "strategy": "none", "begin_s": 0.0, "end_s": 1.0}]
    crash = {"run_id": "a", "kind": "rear_end"}
    crashes = [
        crash | {"secondary": False, "struck_death_risk": 0.2, "struck_serious_risk": 0.5},
        crash | {"secondary": True, "striker_serious_risk": 0.1},
    ]
    table = [{"run_id": "a", "exposed_s": 0.5} | dict(zip(names, row, strict=True)) for row in rows]
    return analysis.Dataset.of(Results.of({"runs": runs, "crashes": crashes, "conflicts": table}))


@pytest.fixture
def encounters():
    return conflicts(
        *[("following", True, False, False, 1.0 + k, None) for k in range(9)],
        ("following", True, False, True, 1.0, None),
        ("following", False, True, False, 0.0, None),
        ("crossing", True, False, False, np.inf, 1.2),
    )


def test_near_crashes_per_crash_count_primary_rear_end_ones(encounters):
    row = analysis.near_crash_ratio(encounters).loc["none"]
    assert (row["near_crashes"], row["crashes"], row["ratio"]) == (9, 1, 9.0)
    # Clopper and Pearson for 9 of 10: 0.5550 to 0.9975.
    assert (row["low"], row["high"]) == pytest.approx((0.55498 / 0.44502, 0.99747 / 0.00253), rel=2e-3)


def test_conflicts_by_kind_and_their_distributions(encounters):
    assert analysis.conflict_counts(encounters)["none"].to_dict() == {"crossing": 1, "following": 11}
    statistics = analysis.conflict_statistics(encounters).loc["none"]
    assert statistics.loc[("following", "min_ttc_s"), "count"] == 10, "the crash is left out"
    assert statistics.loc[("crossing", "min_ttc_s"), "count"] == 0, "an infinite TTC does not count"
    assert statistics.loc[("crossing", "pet_s"), "50%"] == 1.2


def test_summary_has_conflicts_and_what_crashes_do_to_people(encounters):
    table = analysis.summary(encounters)["none"]
    assert table["crashes", "expected deaths", "persons"] == 0.2
    assert table["crashes", "expected seriously injured", "persons"] == 0.6
    assert table["conflicts", "conflicts", ""] == 12
    assert table["conflicts", "primary rear-end near-crashes per crash", "1"] == 9.0
    assert table["conflicts", "time at a TTC below 1.5 s", "s"] == 6.0


def test_runs_of_one_strategy_with_other_sensors_are_different_groups(data):
    runs = data.runs.assign(sensing=["", "", "ideal", "radar"], parameters=["", "", "", ""])
    groups = replace(data, runs=runs).groups()
    assert groups.tolist() == ["none", "none", "zhao2025, sensing ideal", "zhao2025, sensing radar"]


def test_a_mix_is_a_group_with_rates_of_each_of_its_systems(data):
    """Of the 1,000 km of the first run with AEB, 800 are driven with zhao2025, which does all there is."""
    mix = "yan2025=0.2,zhao2025=0.8"
    runs = data.runs.assign(strategy=data.runs["strategy"].replace("zhao2025", mix))
    one = data.exposure[data.exposure["run_id"] == "zhao2025-0"]
    shares = [one.assign(strategy=name, distance_m=km * 1e3) for name, km in (("yan2025", 200), ("zhao2025", 800))]
    exposure = pd.concat([data.exposure[~data.exposure["run_id"].str.startswith("zhao")], *shares])
    mixed = replace(data, runs=runs.assign(penetration=np.nan), exposure=exposure)
    assert set(mixed.groups()) == {"none", mix}
    row = analysis.intervention_statistics(mixed).loc[(mix, "zhao2025", "partial_brake", "lead")]
    assert row["per_1000_km"] == pytest.approx(2 / 0.8)
    table = analysis.summary(mixed)[mix]
    assert table["interventions", "braking rate", "1/10³ km"] == pytest.approx(2.0)
    assert table["interventions", "  zhao2025", "1/10³ km"] == pytest.approx(2 / 0.8)
    assert table["interventions", "  yan2025", "1/10³ km"] == 0
