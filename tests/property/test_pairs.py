from hypothesis import given, settings
from hypothesis import strategies as st

import analysis
from aeb_sumo.results import Results
from aeb_sumo.units import KMH
from aeb_sumo.verdicts import Hit, Outcome, verdict

vehicles = st.sampled_from("abcdef")
risks = st.one_of(st.none(), st.floats(0, 1))
crash = st.fixed_dictionaries(
    {
        "striker": vehicles,
        "struck": vehicles,
        "time_s": st.floats(0, 300),
        "impact_speed_mps": st.floats(0, 40),
        "secondary": st.booleans(),
        "struck_serious_risk": risks,
        "striker_serious_risk": risks,
    }
).filter(lambda one: one["striker"] != one["struck"])
# A pair of vehicles crashes once in a run.
crashes = st.lists(crash, max_size=8, unique_by=lambda one: frozenset({one["striker"], one["struck"]}))
worlds = st.lists(st.tuples(crashes, crashes, crashes), min_size=1, max_size=3)


@settings(max_examples=25, deadline=None)
@given(worlds)
def test_outcomes_add_up_to_the_crashes_of_either_world(seeds):
    tables = {"runs": [], "crashes": []}
    for seed, three in enumerate(seeds):
        for name, some in zip(("none", "x", "y"), three, strict=True):
            run = {"run_id": f"{name}-{seed}"}
            tables["runs"].append(run | {"strategy": name, "seed": seed, "begin_s": 0.0, "end_s": 300.0})
            tables["crashes"] += [run | {"crash_id": k} | one for k, one in enumerate(some)]
    data = analysis.Dataset.of(Results.of(tables))
    table, totals = analysis.pairs(data), data.crashes.groupby("run_id").size()
    assert set(table["outcome"]) <= {"avoided", "mitigated", "unchanged", "worsened", "new"}
    for name in ("x", "y"):
        for seed in range(len(seeds)):
            outcomes = table.loc[table["run_id"] == f"{name}-{seed}", "outcome"]
            assert (outcomes != "avoided").sum() == totals.get(f"{name}-{seed}", 0)
            assert (outcomes != "new").sum() == totals.get(f"none-{seed}", 0)


speeds = st.one_of(st.floats(0, 40), st.sampled_from([0.0, KMH, 2 * KMH, 10.0]))
known = st.one_of(st.none(), st.sampled_from([0.1, 0.2]))


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(speeds, speeds, known, known), min_size=1, max_size=20))
def test_a_pair_that_crashes_in_both_worlds_is_compared_as_a_verdict_does(cases):
    tables = {"runs": [], "crashes": []}
    for name, k in (("none", 0), ("x", 1)):
        tables["runs"].append({"run_id": name, "strategy": name, "seed": 1, "begin_s": 0.0, "end_s": 300.0})
        for number, case in enumerate(cases):
            tables["crashes"].append(
                {"run_id": name, "crash_id": number, "time_s": float(number), "impact_speed_mps": case[k]}
                | {"striker": f"a{number}", "struck": f"b{number}", "struck_serious_risk": case[2 + k]}
            )
    table = analysis.pairs(analysis.Dataset.of(Results.of(tables)))
    for case, outcome in zip(cases, table["outcome"], strict=True):
        without, with_ = (
            Outcome(hits=(Hit(pair=("a", "b"), own=True, impact_speed=case[k], delta_v=0.0, serious_risk=case[2 + k]),))
            for k in (0, 1)
        )
        assert outcome == verdict(with_, without)
