from dataclasses import replace

import pandas as pd
import pytest

import analysis
from aeb_sumo.errors import InputError
from aeb_sumo.results import Results

SETTINGS = {"scenario": "s", "drivers": "d", "step_length_s": 0.1, "begin_s": 0.0, "end_s": 300.0, "demand": 1.0}


def crash(striker, struck, time, speed, *, secondary=False, serious=None):
    return {"striker": striker, "struck": struck, "time_s": time, "impact_speed_mps": speed, "kind": "rear_end"} | {
        "secondary": secondary,
        "struck_serious_risk": serious,
        "striker_vclass": "passenger",
        "struck_vclass": "truck",
    }


def act(vehicle, target, begin):
    return {"vehicle": vehicle, "target": target, "begin_s": begin}


def dataset(*runs):
    """Runs as (strategy, seed, crashes, interventions, settings)."""
    tables = {"runs": [], "crashes": [], "interventions": []}
    for strategy, seed, crashes, interventions, settings in runs:
        run = {"run_id": "-".join([strategy, *map(str, settings.values()), str(seed)])}
        tables["runs"].append(run | SETTINGS | {"strategy": strategy, "seed": seed} | settings)
        tables["crashes"] += [run | {"crash_id": k} | one for k, one in enumerate(crashes)]
        tables["interventions"] += [run | one for one in interventions]
    return analysis.Dataset.of(Results.of(tables))


@pytest.fixture
def data():
    """One seed: of six crashes two are avoided; two more are new."""
    before = [
        crash("a", "b", 100.0, 10.0),
        crash("c", "d", 110.0, 10.0, secondary=True),
        crash("e", "f", 120.0, 10.0),
        crash("g", "h", 130.0, 10.0, serious=0.20),
        crash("i", "j", 140.0, 10.0),
        crash("k", "l", 150.0, 10.0, serious=0.20),
    ]
    after = [
        crash("e", "f", 119.0, 10.2),
        crash("h", "g", 131.0, 11.0, serious=0.10),
        crash("i", "j", 140.0, 12.0, serious=0.10),
        crash("k", "l", 150.0, 9.0, serious=0.25, secondary=True),
        crash("x", "y", 90.0, 3.0),
        crash("x", "a", 95.0, 3.0, secondary=True),
    ]
    acts = [act("b", "a", 104.9), act("z", "c", 109.0), act("d", "c", 94.9), act("c", "d", 115.1)]
    return dataset(("none", 1, before, [], {}), ("zhao2025", 1, after, acts, {}))


def test_every_crash_of_either_world_has_an_outcome(data):
    table = analysis.pairs(data)
    outcomes = {frozenset({row.striker, row.struck}): (row.outcome, row.how) for row in table.itertuples()}
    assert outcomes == {
        frozenset("ab"): ("avoided", "intervened"),  # whoever of the two brakes, 4.9 s after the baseline's crash
        frozenset("cd"): ("avoided", "diverged"),  # for another vehicle, 15.1 s before it and 5.1 s after
        frozenset("ef"): ("unchanged", ""),  # 0.2 m/s is less than 1 km/h
        frozenset("gh"): ("mitigated", ""),  # faster, but the risk is what counts, whoever hits whom
        frozenset("ij"): ("worsened", ""),  # a risk is known in one world only, so the speed counts
        frozenset("kl"): ("worsened", ""),  # slower at a larger risk
        frozenset("xy"): ("new", ""),
        frozenset("xa"): ("new", ""),
    }


def test_a_pair_has_both_worlds_side_by_side(data):
    table = analysis.pairs(data).set_index("striker")
    row = table.loc["g"]
    assert (row["run_id"], row["baseline_run_id"], row["seed"], row["group"]) == ("zhao2025-1", "none-1", 1, "zhao2025")
    assert (row["baseline_time_s"], row["time_s"]) == (130.0, 131.0)
    assert (row["baseline_impact_speed_mps"], row["impact_speed_mps"]) == (10.0, 11.0)
    assert (row["baseline_serious_risk"], row["serious_risk"]) == (0.20, 0.10)
    assert (row["struck"], row["striker_vclass"], row["struck_vclass"]) == ("h", "passenger", "truck")
    assert pd.isna(table.loc["a", "time_s"])
    assert pd.isna(table.loc["a", "secondary"])
    assert not table.loc["a", "baseline_secondary"]
    assert table.loc["k", "secondary"]
    assert list(table["baseline_time_s"].dropna()) == sorted(table["baseline_time_s"].dropna())


def test_a_crash_with_a_person_is_a_pair_as_well():
    person = crash("a", "person:p", 100.0, 10.0)
    table = analysis.pairs(dataset(("none", 1, [person], [], {}), ("b", 1, [], [act("a", "person:p", 95.0)], {})))
    assert table[["outcome", "how"]].to_numpy().tolist() == [["avoided", "intervened"]]


def test_every_run_meets_the_baseline_of_its_own_seed_and_settings():
    one, two = crash("a", "b", 1.0, 5.0), crash("c", "d", 1.0, 5.0)
    wet, dry = {"weather": "wet", "mu": 0.5}, {"weather": "", "mu": 0.85}
    table = analysis.pairs(
        dataset(
            ("none", 1, [one], [], dry),
            ("none", 2, [two], [], dry),
            ("none", 1, [one, two], [], wet),
            ("x", 1, [], [], dry),
            ("x", 2, [one], [], dry),
            ("x", 1, [one], [], wet),
            ("y", 1, [], [], dry),
        )
    )
    assert table.groupby(["run_id", "outcome"]).size().to_dict() == {
        ("x--0.85-1", "avoided"): 1,
        ("x--0.85-2", "avoided"): 1,
        ("x--0.85-2", "new"): 1,
        ("x-wet-0.5-1", "avoided"): 1,
        ("x-wet-0.5-1", "unchanged"): 1,
        ("y--0.85-1", "avoided"): 1,
    }
    assert set(table["group"]) == {
        "x, weather default, mu 0.85",
        "x, weather wet, mu 0.5",
        "y, weather default, mu 0.85",
    }


def test_another_system_can_be_the_baseline(data):
    runs = data.runs.assign(strategy=["x", "zhao2025"])
    assert len(analysis.pairs(replace(data, runs=runs), "x")) == 8
    assert len(analysis.pairs(replace(data, runs=runs), "zhao2025")) == 8


@pytest.mark.parametrize(
    ("runs", "message"),
    [
        ([("x", 1, [], [], {})], r"no runs of 'none', so no pairs; there are x"),
        ([("none", 1, [], [], {})], r"nothing but runs of 'none'"),
        ([("none", 1, [], [], {}), ("x", 2, [], [], {})], r"no run of 'none' with the settings of x-2: seed 2"),
        ([("none", 1, [], [], {}), ("x", 1, [], [], {"mu": 0.5})], r"the settings of x-0.5-1: mu 0.5"),
        ([("none", 1, [], [], {}), ("x", 1, [], [], {"end_s": 17.0})], r"the settings of x-17.0-1: end_s 17.0"),
        ([("none", 1, [], [], {}), ("none", 1, [], [], {"penetration": 0.0}), ("x", 1, [], [], {})], "more than one"),
    ],
)
def test_a_run_without_its_baseline_is_named(runs, message):
    with pytest.raises(InputError, match=message):
        analysis.pairs(dataset(*runs))


def test_runs_without_crashes_have_no_pairs_but_counts():
    data = dataset(("none", 1, [], [], {}), ("x", 1, [], [], {}))
    assert analysis.pairs(data).empty
    counts = analysis.pair_counts(data)
    assert counts["count"].tolist() == [0] * 5
    assert counts[["low", "high"]].isna().all(axis=None)


def test_pair_counts_and_their_parts(data):
    counts = analysis.pair_counts(data).loc["zhao2025"]
    assert counts["count"].to_dict() == {"avoided": 2, "mitigated": 1, "unchanged": 1, "worsened": 2, "new": 2}
    assert counts["primary"].to_dict() == {"avoided": 1, "mitigated": 1, "unchanged": 1, "worsened": 2, "new": 1}
    assert counts.loc["avoided", ["intervened", "diverged"]].tolist() == [1, 1]
    assert counts["percent"].to_dict() == pytest.approx(
        {"avoided": 100 / 3, "mitigated": 50 / 3, "unchanged": 50 / 3, "worsened": 100 / 3, "new": 100 / 3}
    )
    assert counts["low"].isna().all(), "one seed has no spread"


def test_shares_of_several_seeds_have_bounds():
    """9 of 10, 8 of 10, 7 of 10 crashes avoided."""
    runs = []
    for seed, left in ((1, 1), (2, 2), (3, 3)):
        crashes = [crash(f"a{k}", f"b{k}", 10.0 * k, 5.0) for k in range(10)]
        runs += [("none", seed, crashes, [], {}), ("x", seed, crashes[:left], [], {})]
    row = analysis.pair_counts(dataset(*runs)).loc[("x", "avoided")]
    direct = analysis.share_by_seed([9, 8, 7], [10, 10, 10])
    assert (row["percent"], row["low"], row["high"]) == (direct.estimate, direct.low, direct.high)
    assert 40 < row["low"] < 80 < row["high"] < 98
    new = analysis.pair_counts(dataset(*runs)).loc[("x", "new")]
    # Wilson's bound of 0 of 30, as odds: z2 / 30.
    assert (new["percent"], new["low"], new["high"]) == pytest.approx((0, 0, 100 * 1.959964**2 / 30), rel=1e-5)
    assert new["note"] == "none: crashes taken as independent"


def test_new_crashes_can_be_more_than_there_were_before():
    runs = []
    for seed, number in ((1, 2), (2, 3), (3, 4)):
        new = [crash(f"c{k}", f"d{k}", 10.0 * k, 5.0) for k in range(number)]
        runs += [("none", seed, [crash("a", "b", 1.0, 5.0)], [], {}), ("x", seed, new, [], {})]
    row = analysis.pair_counts(dataset(*runs)).loc[("x", "new")]
    half = 100 * 4.302653 / 3**0.5
    assert (row["count"], row["percent"], row["low"]) == (9, 300, pytest.approx(300 - half))
    assert row["high"] == pytest.approx(300 + half)


def test_mcnemar_counts_pairs_that_crash_in_one_world_only():
    """Five against none: 2 / 2^5. Secondary crashes do not count among the primary ones."""
    before = [crash(f"a{k}", f"b{k}", k, 5.0, secondary=k > 2) for k in range(6)]
    test = analysis.mcnemar_test(dataset(("none", 1, before, [], {}), ("x", 1, before[:1], [], {}))).loc["x"]
    assert test.loc["all"].to_dict() == {"only_baseline": 5, "only_aeb": 0, "both": 1, "p_value": 0.0625}
    assert test.loc["primary"].to_dict() == {"only_baseline": 2, "only_aeb": 0, "both": 1, "p_value": 0.5}
    same = analysis.mcnemar_test(dataset(("none", 1, before, [], {}), ("x", 1, before, [], {}))).loc[("x", "all")]
    assert (same["both"], same["p_value"]) == (6, 1.0)
