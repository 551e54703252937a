import numpy as np
import pytest

import analysis
from aeb_sumo.results import Results

# Per seed and world: crashes (of these secondary), delay [s] on 100 km in 2 vehicle-hours, arrivals, in 360 s.
WORLDS = {
    "none": [(4, 1, 300.0, 100), (6, 3, 500.0, 90), (8, 2, 400.0, 110)],
    "x": [(3, 0, 200.0, 105), (3, 1, 450.0, 95), (6, 1, 300.0, 120)],
    "y": [(0, 0, 300.0, 100), (0, 0, 500.0, 90), (0, 0, 400.0, 110)],
}


def dataset(worlds, *, share=1.0):
    tables = {"runs": [], "crashes": [], "traffic": [], "exposure": []}
    for name, seeds in worlds.items():
        for seed, (crashes, secondary, delay, arrived) in enumerate(seeds):
            run = {"run_id": f"{name}-{seed}"}
            tables["runs"].append(run | {"strategy": name, "seed": seed, "begin_s": 0.0, "end_s": 360.0})
            tables["crashes"] += [
                run | {"striker": f"a{k}", "struck": f"b{k}", "time_s": k, "impact_speed_mps": 5.0, "crash_id": k}
                | {"secondary": k < secondary, "struck_serious_risk": 0.1 * share}
                for k in range(crashes)
            ]  # fmt: skip
            # Two intervals and two classes, which add up.
            for k, part in enumerate((0.25, 0.75)):
                row = {"begin_s": 180.0 * k, "end_s": 180.0 * (k + 1), "vclass": "passenger"}
                row |= {"distance_m": 1e5 * part, "time_s": 7200 * part, "delay_s": delay * part}
                tables["traffic"].append(run | row | {"arrived": arrived * (1 - k)})
            tables["exposure"].append(run | {"vclass": "passenger", "distance_m": 1e5, "time_s": 7200.0})
    return analysis.Dataset.of(Results.of(tables))


@pytest.fixture(scope="module")
def data():
    return dataset(WORLDS)


@pytest.fixture(scope="module")
def effect(data):
    return analysis.effect(data).droplevel("unit")


def test_every_group_has_every_figure_against_the_baseline(data, effect):
    figures = analysis.effect(data).loc["x"]
    assert list(figures.index) == [
        ("crashes", "1/run"),
        ("primary crashes", "1/run"),
        ("expected deaths", "1/run"),
        ("expected seriously injured", "1/run"),
        ("delay", "s/km"),
        ("flow", "1/h"),
        ("mean speed", "km/h"),
    ]
    assert list(effect.index.unique("group")) == ["x", "y"]
    assert effect.loc["x", "baseline"].tolist() == pytest.approx([6, 4, 0, 0.6, 4, 1000, 50])
    assert effect.loc["x", "with_aeb"].tolist() == pytest.approx([4, 10 / 3, 0, 0.4, 19 / 6, 3200 / 3, 50])


def test_differences_and_percent_are_those_of_paired_intervals(effect):
    """Crashes: -1, -3, -2."""
    row, half = effect.loc[("x", "crashes")], 4.302653 / np.sqrt(3)
    assert (row["difference"], row["low"], row["high"]) == pytest.approx((-2, -2 - half, -2 + half), rel=1e-6)
    percent = analysis.paired_interval([4, 6, 8], [3, 3, 6], percent=True)
    assert (row["percent"], row["percent_low"], row["percent_high"]) == (percent.estimate, percent.low, percent.high)
    assert (row["seeds"], row["method"], row["note"]) == (3, "t by seed", "few seeds: may be too narrow")
    delay = effect.loc[("x", "delay")]
    direct = analysis.paired_interval([3, 5, 4], [2, 4.5, 3])
    assert (delay["difference"], delay["low"], delay["high"]) == pytest.approx(
        (direct.estimate, direct.low, direct.high)
    )


def test_severity_is_the_sum_of_the_risks(effect):
    row = effect.loc[("x", "expected seriously injured")]
    direct = analysis.paired_interval([0.4, 0.6, 0.8], [0.3, 0.3, 0.6])
    assert (row["difference"], row["low"], row["high"]) == pytest.approx((-0.2, direct.low, direct.high))
    assert row["percent"] == pytest.approx(-100 / 3)


def test_where_no_crash_is_left_two_poisson_rates_bound_the_percentage(effect):
    row = effect.loc[("y", "crashes")]
    assert (row["difference"], row["percent"], row["percent_low"]) == (-6, -100, -100)
    # Wilson's bound of 0 of 18, as odds: z2 / 18.
    assert row["percent_high"] == pytest.approx(100 * (1.959964**2 / 18 - 1), rel=1e-5)
    assert "none left" in row["note"]
    assert row["high"] < 0


def test_what_does_not_differ_has_no_bounds(effect):
    row = effect.loc[("y", "delay")]
    assert (row["difference"], row["percent"], row["note"]) == (0, 0, "no spread between the seeds")
    assert np.isnan([row["low"], row["high"], row["percent_low"], row["percent_high"]]).all()


def test_one_seed_has_estimates_and_no_bounds():
    table = analysis.effect(dataset({name: seeds[:1] for name, seeds in WORLDS.items()}))
    assert table[["low", "high", "percent_low", "percent_high"]].isna().all(axis=None)
    assert table.loc[("y", "crashes", "1/run"), ["difference", "percent"]].tolist() == [-4, -100]


def test_another_system_can_be_the_baseline(data):
    table = analysis.effect(data, baseline="x")
    assert table.loc[("none", "crashes", "1/run"), "difference"] == 2


def test_rate_ratios_of_groups(data):
    table = analysis.crash_rate_ratios(data)
    row = table.loc[("x", "all")]
    direct = analysis.rate_ratio(count=12, exposure=3e5, baseline_count=18, baseline_exposure=3e5)
    assert row.to_dict() == {"count": 12, "baseline_count": 18, "ratio": direct.ratio} | {
        "low": direct.low,
        "high": direct.high,
    }
    assert table.loc[("x", "primary"), ["count", "baseline_count"]].tolist() == [10, 12]
    with pytest.raises(KeyError, match="no group 'z'; there are none, x, y"):
        analysis.crash_rate_ratios(data, baseline="z")


def test_planning_of_a_rate_takes_the_spread_of_the_seeds_into_account():
    """2, 4 and 12 crashes vary 14/3 times as much as a Poisson number of mean 6: variance 28."""
    world = [(n, 0, 300.0, 100) for n in (2, 4, 12)]
    row = analysis.planning(dataset({"none": world, "x": WORLDS["x"]}), relative=0.2).loc[("none", "crash rate")]
    assert row["seeds_needed"] == np.ceil(102 * 28 / 6 / 6)
    assert row["km_needed"] == 100 * row["seeds_needed"]
    assert (row["seeds_missing"], row["km_missing"]) == (row["seeds_needed"] - 3, row["km_needed"] - 300)
    assert "4.7 times" in row["note"]
    even = analysis.planning(dataset(WORLDS)).loc[("none", "crash rate")]
    assert even["seeds_needed"] == np.ceil(102 / 6), "4, 6 and 8 crashes vary less than Poisson numbers"
    rate = analysis.poisson_rate(18, 1.0)
    assert even["half_width"] == pytest.approx(100 * (rate.high - rate.low) / 2 / 18)


def test_planning_without_a_crash_reads_the_rule_of_three(data):
    row = analysis.planning(data).loc[("y", "crash rate")]
    # At most 3 crashes in the 300 km of three seeds.
    assert row["seeds_needed"] == np.ceil(102 / (2.9957 / 3))
    assert row["note"] == "no crash: at least so many"
    assert np.isnan(row["half_width"])


def test_planning_of_a_reduction(data):
    table = analysis.planning(data, points=10.0)
    row = table.loc[("x", "reduction of crashes")]
    now = analysis.paired_interval([4, 6, 8], [3, 3, 6], percent=True)
    assert row["half_width"] == pytest.approx((now.high - now.low) / 2)
    assert row["seeds_needed"] == analysis.seeds_needed(now, 10.0)
    assert row["km_needed"] == pytest.approx(100 * row["seeds_needed"])
    assert np.isnan(table.loc[("y", "reduction of crashes"), "seeds_needed"]), "nothing is left: no spread"
    assert list(table.loc["none"].index) == ["crash rate"]
    wide = analysis.planning(data, points=500.0, relative=5.0)
    assert wide.loc[("x", "reduction of crashes"), "seeds_missing"] == 0
