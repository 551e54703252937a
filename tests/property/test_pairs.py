from hypothesis import given, settings
from hypothesis import strategies as st

import analysis
from aeb_sumo.results import Results

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
