import pandas as pd
import pytest

import analysis
from aeb_sumo.errors import InputError
from aeb_sumo.results import Results

RUN = {"scenario": "s", "drivers": "d", "step_length_s": 0.1, "begin_s": 0.0, "end_s": 300.0, "demand": 1.0, "seed": 1}

# crash: (kind, perfect, careful, under AEB: impact speed, or None for no crash)
CRASHES = [
    ("rear_end", "avoided", "avoided", None),
    ("rear_end", "avoided", "mitigated", 10.0),
    ("rear_end", "avoided", "unknown", 5.0),
    ("rear_end", "mitigated", "unchanged", None),
    ("rear_end", "unknown", "unknown", 10.0),
    ("crossing", "other", "worsened", 10.0),
    ("crossing", "avoided", "avoided", None),
]


@pytest.fixture
def data():
    base, aeb = {"run_id": "none-1"}, {"run_id": "zhao2025-1"}
    crashes, ceilings = [], []
    for k, (kind, perfect, careful, speed) in enumerate(CRASHES):
        who = {"striker": f"a{k}", "struck": f"b{k}", "kind": kind, "crash_id": k, "time_s": 10.0 * k}
        crashes.append(base | who | {"impact_speed_mps": 10.0, "secondary": False})
        if speed is not None:
            crashes.append(aeb | who | {"impact_speed_mps": speed, "secondary": False})
        ceilings.append(base | {"crash_id": k, "ceiling": "perfect", "outcome": perfect})
        ceilings.append(base | {"crash_id": k, "ceiling": "careful", "outcome": careful})
    runs = [base | RUN | {"strategy": "none"}, aeb | RUN | {"strategy": "zhao2025"}]
    return analysis.Dataset.of(Results.of({"runs": runs, "crashes": crashes, "ceilings": ceilings}))


def test_shares_of_the_crashes_that_each_ceiling_avoids(data):
    shares = analysis.ceiling_shares(data)
    perfect, careful = shares.loc["perfect"], shares.loc["careful"]
    assert perfect[["crashes", "avoided", "mitigated", "other", "unknown"]].tolist() == [7, 4, 1, 1, 1]
    assert perfect["percent"] == pytest.approx(100 * 4 / 6), "of those that are known"
    assert perfect["low"] < perfect["percent"] < perfect["high"]
    assert careful[["avoided", "mitigated", "unchanged", "worsened", "unknown"]].tolist() == [2, 1, 1, 1, 2]


def test_shares_by_columns_of_the_crashes_add_up(data):
    by = analysis.ceiling_shares(data, by="kind")
    assert by.loc[("perfect", "rear_end"), "avoided"] == 3
    assert by.loc[("perfect", "crossing"), "avoided"] == 1
    total = analysis.ceiling_shares(data)
    for column in ("crashes", "avoided", "unknown"):
        pd.testing.assert_series_equal(by.groupby("ceiling")[column].sum(), total[column])
    assert analysis.ceiling_shares(data, by=["kind", "secondary"]).index.names == ["ceiling", "kind", "secondary"]


def test_what_the_strategy_left_of_what_physics_allows(data):
    left = analysis.ceilings_left(data).loc["zhao2025"]
    assert left["crashes"] == 6
    assert left[["unavoidable", "avoided_anyway"]].tolist() == [2, 1]
    assert left[["avoidable", "careful", "avoided", "left"]].tolist() == [4, 2, 2, 2]
    assert left["percent"] == 50
    by = analysis.ceilings_left(data, by="kind")
    assert by.loc[("zhao2025", "crossing"), ["unavoidable", "avoidable", "left"]].tolist() == [1, 1, 0]
    assert by.loc[("zhao2025", "rear_end"), "left"] == 2


def test_no_ceilings_and_no_such_column_are_one_line(data):
    none = analysis.Dataset.of(Results.of({"runs": [{"run_id": "a"} | RUN]}))
    with pytest.raises(InputError, match=r"^no run has ceilings; run the baseline with --ceilings"):
        analysis.ceiling_shares(none)
    with pytest.raises(InputError, match=r"^crashes have no column 'sort'; there are: run_id, crash_id"):
        analysis.ceilings_left(data, by="sort")
