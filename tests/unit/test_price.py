from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.stats import t as student

import analysis
from aeb_sumo.errors import InputError
from aeb_sumo.results import Results
from analysis import delay_per_avoided_crash

# Per seed: (arrivals in each of 4 intervals of 150 s, crashes, hours of delay), without AEB and with it.
WORLDS = {
    "none": {1: ((0, 10, 20, 30), 4, 2.0), 2: ((0, 20, 20, 20), 6, 3.0)},
    "zhao2025": {1: ((0, 10, 30, 30), 1, 2.5), 2: ((0, 20, 20, 20), 3, 4.5)},
}


def dataset(worlds=WORLDS):
    runs, crashes, traffic = [], [], []
    for strategy, seeds in worlds.items():
        for seed, (arrivals, count, delay) in seeds.items():
            one = {"run_id": f"{strategy}-{seed}"}
            same = {
                "scenario": "s",
                "demand": 1.0,
                "mu": 0.85,
                "drivers": "d",
                "step_length_s": 0.1,
                "blockage_s": 60.0,
            }
            runs.append(one | same | {"strategy": strategy, "seed": seed, "begin_s": 100.0, "end_s": 700.0})
            crashes += [one | {"time_s": 150.0 + 100 * k} for k in range(count)]
            for k, arrived in enumerate(arrivals):
                row = one | {"vclass": "passenger", "begin_s": 100.0 + 150 * k, "end_s": 250.0 + 150 * k}
                row |= {"arrived": arrived, "travel_time_s": 60.0 * arrived, "distance_m": 1e4, "time_s": 1e3}
                # A quarter each on the road and at the entry, in two intervals: half of it on the road.
                row |= {"delay_s": delay * 450, "waiting_s": delay * 450, "blocked_s": 90.0 * count, "stops": 5}
                row |= {"standing_s": 0.0, "discharged": arrived, "headway_s": 2.0 * arrived}
                traffic.append(row)
    return analysis.Dataset.of(Results.of({"runs": runs, "crashes": crashes, "traffic": traffic}))


def figure(table, name, group="zhao2025"):
    return table.loc[group].droplevel("unit").loc[name]


def test_every_figure_by_hand():
    table = analysis.traffic_price(dataset())
    columns = ["baseline", "with_aeb", "difference"]
    for name, values in {
        "flow": (120 / (1200 / 3600), 130 / (1200 / 3600), 30),
        "largest flow in 5 min": ((50 + 40) / 2 * 12, (60 + 40) / 2 * 12, 60),
        "flow per lane out of queues": (1800, 1800, 0),
        "travel time": (60, 60, 0),
        "speed": (36, 36, 0),
        "delay on the road": (1800 * (2 + 3) / 80, 1800 * (2.5 + 4.5) / 80, 45),
        "stops": (0.5, 0.5, 0),
        "delay": (2.5, 3.5, 1),
        "  waiting to enter": (1.25, 1.75, 0.5),
        "  behind wrecks": (0.5, 0.2, -0.3),
        "crashes": (5, 2, -3),
    }.items():
        assert figure(table, name)[columns].tolist() == pytest.approx(values), name
    assert figure(table, "delay")["percent"] == pytest.approx(40)
    # Differences of 0.5 and 1.5 h: mean 1, standard error 0.5.
    half = student.ppf(0.975, 1) * 0.5
    assert figure(table, "delay")[["low", "high"]].tolist() == pytest.approx([1 - half, 1 + half])
    assert figure(table, "delay")["seeds"] == 2


def test_delay_per_avoided_crash_is_hours_by_crashes():
    row = figure(analysis.traffic_price(dataset()), "extra delay per avoided crash")
    assert row["difference"] == pytest.approx((0.5 + 1.5) / (3 + 3))


def test_one_seed_has_no_bounds():
    one = dataset({name: {1: seeds[1]} for name, seeds in WORLDS.items()})
    table = analysis.traffic_price(one)
    assert table[["low", "high"]].isna().all().all()
    assert figure(table, "delay")["difference"] == pytest.approx(0.5)


def test_a_warm_up_leaves_out_what_comes_before():
    table = analysis.traffic_price(dataset(), warm_up=300)
    assert figure(table, "flow")["baseline"] == pytest.approx(90 / (600 / 3600))
    assert figure(table, "delay")["baseline"] == pytest.approx(1.25)
    # Crashes at 150, 250, 350, 450 ... s in runs that begin at 100 s.
    assert figure(table, "crashes")["baseline"] == pytest.approx((1 + 3) / 2)
    for wrong in (-1, 600, np.nan):
        with pytest.raises(InputError, match="warm-up"):
            analysis.traffic_price(dataset(), warm_up=wrong)


def test_a_run_shorter_than_five_minutes_has_no_largest_flow():
    data = dataset({name: {1: ((5,), 0, 1.0), 2: ((7,), 0, 1.0)} for name in WORLDS})
    assert np.isnan(figure(analysis.traffic_price(data), "largest flow in 5 min")["baseline"])


def test_without_a_baseline_there_is_no_price():
    with pytest.raises(InputError, match="none"):
        analysis.traffic_price(dataset({"zhao2025": WORLDS["zhao2025"]}))


def test_bounds_of_the_ratio_are_where_the_difference_cannot_be_told_from_nothing():
    extra, avoided = np.array([1.0, 3.0, 2.0, 5.0, 1.5]), np.array([9.0, 12.0, 10.0, 15.0, 8.0])
    found = delay_per_avoided_crash(extra, avoided)
    for bound in (found.low, found.high):
        rest = extra - bound * avoided
        assert abs(rest.mean()) == pytest.approx(student.ppf(0.975, 4) * rest.std(ddof=1) / np.sqrt(5))
    assert found.estimate == pytest.approx(extra.sum() / avoided.sum())
    assert found.low < found.estimate < found.high


def test_nothing_avoided_or_too_little_of_it():
    extra = np.array([1.0, 2.0, 3.0])
    for avoided in (np.zeros(3), np.array([1.0, -1.0, 0.0]), np.array([0.0, -2.0, 0.0])):
        found = delay_per_avoided_crash(extra, avoided)
        assert np.isnan([found.estimate, found.low, found.high]).all()
        assert found.note == "no crash avoided"
    few = delay_per_avoided_crash(extra, np.array([0.0, 3.0, 0.0]))
    assert (few.estimate, few.low, few.high) == (2.0, -np.inf, np.inf)
    same = delay_per_avoided_crash(np.full(3, 2.0), np.full(3, 4.0))
    assert same.estimate == 0.5
    assert np.isnan([same.low, same.high]).all()


@pytest.mark.parametrize(("seeds", "crashes"), [(5, 10.0), (20, 4.0), (20, 0.3)])
def test_the_interval_of_the_ratio_covers_the_truth(seeds, crashes):
    """Poisson crashes, delays that go with them: the truth of 0.5 h is inside in 93 to 97 % of the experiments.

    With few crashes many intervals have no bounds, and those cover it; those without an estimate are left out.
    """
    rng = np.random.default_rng(1)
    inside = []
    for _ in range(2000):
        avoided = rng.poisson(crashes, seeds).astype(float)
        found = delay_per_avoided_crash(0.5 * avoided + rng.normal(0, 1, seeds), avoided)
        if np.isfinite(found.estimate) and not np.isnan(found.low):
            inside.append(found.low <= 0.5 <= found.high)
    assert len(inside) > 1900
    assert 0.93 < np.mean(inside) < (0.97 if crashes > 1 else 1.0)


def test_throughput_over_time_is_the_mean_of_the_seeds_with_its_band():
    table = analysis.throughput_over_time(dataset()).loc["none"]
    assert table.index.tolist() == [(150.0 * k, 150.0 * (k + 1)) for k in range(4)]
    row = table.iloc[1]
    assert row["flow_vph"] == pytest.approx((10 + 20) / 2 * 24)
    half = student.ppf(0.975, 1) * 5 * 24
    assert row[["flow_vph_low", "flow_vph_high"]].tolist() == pytest.approx([360 - half, 360 + half])
    assert (row["speed_kmh"], row["vehicles"], row["seeds"]) == (pytest.approx(36), pytest.approx(1e3 / 150), 2)
    assert row["delay_share"] == pytest.approx((0.9 + 1.35) / 2)


def test_an_interval_with_nobody_on_the_road_counts_as_no_flow():
    data = dataset()
    first = (data.traffic["run_id"] == "none-1") & (data.traffic["begin_s"] == 100)
    table = analysis.throughput_over_time(replace(data, traffic=data.traffic[~first])).loc["none"]
    row = table.iloc[0]
    assert (row["seeds"], row["flow_vph"], row["vehicles"]) == (2, 0, pytest.approx(1e3 / 150 / 2))
    assert row["speed_kmh"] == pytest.approx(36), "of the seed that has one"


def test_a_run_that_ends_early_has_no_part_in_what_comes_after():
    data = dataset()
    runs = data.runs.assign(end_s=data.runs["end_s"].where(data.runs["run_id"] != "none-1", 400.0))
    traffic = data.traffic[(data.traffic["run_id"] != "none-1") | (data.traffic["end_s"] <= 400)]
    table = analysis.throughput_over_time(replace(data, runs=runs, traffic=traffic)).loc["none"]
    assert table["seeds"].tolist() == [2, 2, 1, 1]
    assert np.isnan(table["flow_vph_low"].iloc[3])
    assert isinstance(table, pd.DataFrame)


def test_a_run_with_nobody_on_the_road_has_nothing_over_time_and_no_price_but_crashes():
    data = dataset()
    empty = replace(data, traffic=data.traffic[:0])
    assert len(analysis.throughput_over_time(empty)) == 0
    table = analysis.traffic_price(empty)
    assert figure(table, "flow")["baseline"] == 0
    assert np.isnan(figure(table, "travel time")["baseline"])


def test_compare_prints_the_price_or_says_why_there_is_none(tmp_path):
    from click.testing import CliRunner

    from aeb_sumo.cli.tables import compare
    from aeb_sumo.results import write

    def tables(strategy, seed):
        settings = {"scenario": "s", "begin_s": 0.0, "end_s": 60.0, "strategy": strategy, "seed": seed}
        row = {"begin_s": 0.0, "end_s": 60.0, "vclass": "passenger", "delay_s": 3600.0 * seed, "distance_m": 1e3}
        run = {"run_id": f"{strategy}-{seed}"}
        return Results.of({"runs": [run | settings], "traffic": [run | row | {"time_s": 7200.0}]})

    for folder, other in (("same", 1), ("different", 2)):
        write(tables("none", 1), tmp_path / folder)
        write(tables("zhao2025", other), tmp_path / folder)
    same, different = (CliRunner().invoke(compare, [str(tmp_path / name)]) for name in ("same", "different"))
    assert "extra delay per avoided crash [h]" in same.stdout
    assert "no crash avoided" in same.stdout
    assert "has no pairs of runs" in different.stderr
    assert "seed 2" in different.stderr
    assert same.exit_code == different.exit_code == 0


def test_a_run_beside_a_baseline_that_lasted_otherwise_is_no_error(capsys):
    """As after Ctrl-C, or where a run ends when all have arrived."""
    from aeb_sumo.cli.run import _print_pairs

    runs = [
        {"run_id": name, "scenario": "s", "strategy": name, "seed": 1, "begin_s": 0.0, "end_s": end}
        for name, end in (("none", 60.0), ("zhao2025", 50.0))
    ]
    _print_pairs(analysis.Dataset.of(Results.of({"runs": runs})))
    assert "the two runs are no pair: no run of 'none'" in capsys.readouterr().err
