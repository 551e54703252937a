from dataclasses import replace

import fsspec
import numpy as np
import pandas as pd
import pyarrow.compute as pc
import pyarrow.parquet as pq
import pytest

import analysis
from aeb_sumo.errors import InputError
from aeb_sumo.results import TABLES, VERDICTS, Results, commit_failure, read, write
from analysis.report import render
from tests.unit.test_report import ACTIONS, CRASHES, tables

RUN = "highway-zhao2025-p1-s2"


@pytest.fixture(scope="module")
def kept():
    """A baseline and a system, three seeds each, with rows in all tables, and all that a cell can be."""
    rows = tables(CRASHES, ACTIONS) | {"conflicts": []}
    for k, run in enumerate(rows["runs"] * 12):
        one = {"run_id": run["run_id"], "conflict_id": k, "kind": ("following", "crossing")[k % 2], "pet_s": k / 3}
        one |= {"min_ttc_s": (None, np.nan, np.inf, k / 9)[k % 4], "near_crash": k % 5 == 0, "secondary": k % 7 == 0}
        rows["conflicts"].append(one | {"crashed": k % 11 == 0, "exposed_s": 0.1 * k, "max_drac_mps2": float(k)})
    for row in rows["interventions"]:
        row |= {"lane": f":junction_{row['intervention_id'] % 3}_0", "with_follower_decel_mps2": 6.0}
    rows["conflicts"].sort(key=lambda row: row["run_id"])
    of_baseline = [row for row in rows["crashes"] if "none" in row["run_id"]]
    rows["ceilings"] = [
        {"run_id": row["run_id"], "crash_id": row["crash_id"], "ceiling": ceiling, "outcome": outcome}
        for row in of_baseline
        for ceiling, outcome in (("perfect", "avoided"), ("careful", "unchanged"))
    ]
    return Results.of(rows)


@pytest.fixture(scope="module", params=["local", "memory"])
def stored(request, tmp_path_factory, kept):
    """Where nothing is changed."""
    return put(kept, str(tmp_path_factory.mktemp("kept")) if request.param == "local" else "memory://kept")


@pytest.fixture(params=["local", "memory"])
def place(request, tmp_path, kept):
    return put(kept, str(tmp_path) if request.param == "local" else f"memory://{tmp_path.name}")


def put(results, place):
    """Runs side by side."""
    for run in results.runs["run_id"]:
        tables = results.tables.items()
        write(Results({name: rows.filter(pc.equal(rows["run_id"], run)) for name, rows in tables}), place)
    return place


def remove(place, table, run=""):
    fs, root = fsspec.core.url_to_fs(place)
    fs.rm(f"{root}/{table}/{run}.parquet" if run else f"{root}/{table}", recursive=True)


def test_a_stored_table_is_the_one_in_memory(stored, kept):
    data = analysis.load(stored)
    for table in TABLES:
        assert data.count(table) == kept.tables[table].num_rows > 0, table
        pd.testing.assert_frame_equal(getattr(data, table), kept.frame(table))
        assert data.count(table) == kept.tables[table].num_rows


FUNCTIONS = [
    "ceiling_shares", "ceilings_left", "conflict_counts", "conflict_statistics", "crash_counts", "crash_rate_ratios",
    "crash_rates", "effect", "intervention_counts", "intervention_statistics",
    "mcnemar_test", "near_crash_ratio", "pair_counts", "pairs", "passed_on", "planning", "precision_recall",
    "run_figures", "summary", "throughput", "throughput_impact", "throughput_over_time", "traffic_price",
    "verdict_counts", "verdict_rates",
]  # fmt: skip


@pytest.mark.parametrize("name", FUNCTIONS)
def test_an_analysis_of_stored_tables_is_that_of_those_in_memory(stored, kept, name):
    function = getattr(analysis, name)
    there, here = function(analysis.load(stored)), function(analysis.Dataset.of(kept))
    assert len(here)
    pd.testing.assert_frame_equal(there, here)


def test_no_table_is_read_before_it_is_asked_for(place):
    data = analysis.load(place)
    remove(place, "conflicts")
    remove(place, "interventions")
    assert len(analysis.crash_rates(data)) == 2
    assert len(analysis.effect(data))
    with pytest.raises(InputError, match=r"cannot read .*conflicts"):
        data.conflicts  # noqa: B018


def test_a_table_is_read_once(place):
    data = analysis.load(place)
    assert data.crashes is data.crashes
    remove(place, "crashes")
    assert len(data.read("crashes", ["kind"])) == len(data.crashes)
    assert len(data.only(pd.Index([RUN])).crashes) == (data.crashes["run_id"] == RUN).sum()


def test_columns_come_as_they_are_asked_for(stored):
    frame = analysis.load(stored).read("interventions", ["verdict", "run_id"])
    assert list(frame.columns) == ["verdict", "run_id"]


FILTERS = [
    [("verdict", "==", "unneeded")],
    [("verdict", "!=", "unneeded"), ("intervention_id", "<=", 5)],
    [("trigger_ttc_s", ">", 1.4)],
    [("trigger_ttc_s", "!=", 1.6)],
    [("phase", "in", ["warn", "full_brake"]), ("run_id", "not in", [RUN])],
    [[("phase", "==", "warn")], [("phase", "==", "full_brake"), ("speed_reduction_mps", ">=", 10)]],
    [("intervention_id", "in", {1, np.int64(3)}), ("begin_s", "<", np.inf)],
    [("trigger_ttc_s", "not in", [1.6])],
    [("with_crash", "==", True)],
    [],
]


@pytest.mark.parametrize("filters", FILTERS, ids=str)
def test_filters_are_the_same_on_disk_and_in_memory_and_what_pandas_says(stored, kept, filters):
    there, data = analysis.load(stored), analysis.Dataset.of(kept)
    there = there.read("interventions", ["run_id", "intervention_id"], filters)
    here = data.read("interventions", ["run_id", "intervention_id"], filters)
    pd.testing.assert_frame_equal(there, here.reset_index(drop=True))
    operators = {
        "==": lambda a, b: a == b, "!=": lambda a, b: a != b, "<": lambda a, b: a < b, "<=": lambda a, b: a <= b,
        ">": lambda a, b: a > b, ">=": lambda a, b: a >= b, "in": lambda a, b: a.isin(list(b)),
        "not in": lambda a, b: ~a.isin(list(b)),
    }  # fmt: skip
    table, wanted = data.interventions, pd.Series(not filters, index=data.interventions.index)
    for group in filters if filters and isinstance(filters[0], list) else [filters] if filters else []:
        every = pd.Series(True, index=table.index)
        for name, operator, value in group:
            every &= operators[operator](table[name], value).astype(bool) & table[name].notna()
        wanted |= every
    assert len(there) == wanted.sum()


def test_filters_of_runs_choose_files(place, kept):
    remove(place, "interventions", "highway-none-p1-s1")
    data = analysis.load(place, filters=[("strategy", "==", "zhao2025"), ("seed", ">", 1)])
    assert data.runs["seed"].tolist() == [2, 3]
    assert len(data.interventions) == ACTIONS["zhao2025", 2] + ACTIONS["zhao2025", 3]
    assert list(data.by_group()) == ["zhao2025"]


def test_some_runs_of_stored_ones_are_not_read_before_they_are_asked_for(place):
    data = analysis.load(place)
    part = data.only(pd.Index([RUN]))
    remove(place, "interventions", "highway-none-p1-s1")
    assert set(part.interventions["run_id"]) == set(part.runs["run_id"]) == {RUN}
    assert data.only(data.runs["run_id"]) is data
    assert len(data.only(pd.Index([])).interventions) == 0


def test_a_run_without_its_row_in_runs_is_none(place):
    remove(place, "runs", RUN)
    assert RUN not in set(analysis.load(place).crashes["run_id"]) | set(analysis.load(place).interventions["run_id"])


def test_a_stored_data_set_can_be_changed_as_one_in_memory(stored):
    data = analysis.load(stored)
    changed = replace(data, runs=data.runs.assign(mu=0.5))
    assert set(changed.runs["mu"]) == {0.5}
    pd.testing.assert_frame_equal(changed.crashes, data.crashes)


def test_files_of_another_version_are_refused_when_they_are_read(tmp_path, kept):
    write(Results.of({"runs": [{"run_id": "a"}]}), tmp_path)
    data, path = analysis.load(tmp_path), tmp_path / "crashes" / "a.parquet"
    table = pq.read_table(path)
    pq.write_table(table.replace_schema_metadata(table.schema.metadata | {b"schema_version": b"3"}), path)
    assert len(data.interventions) == 0
    for ask in (lambda: data.crashes, lambda: data.count("crashes"), lambda: data.read("crashes", ["kind"])):
        with pytest.raises(InputError, match=r"crashes/a.parquet .* version 3 instead of"):
            ask()


@pytest.mark.parametrize(
    ("table", "columns", "filters", "why"),
    [
        ("crash", None, None, "no table 'crash'; there are: runs, crashes"),
        ("crashes", ["speed"], None, "crashes has no column 'speed'; there are: run_id, crash_id"),
        ("crashes", "kind", None, "must be a list of names, not 'kind'"),
        ("crashes", None, [("speed", "<", 3)], "crashes has no column 'speed'"),
        ("crashes", None, [("kind", "=", "side")], r"cannot read the filter .*operator one of ==, !=, <"),
        ("crashes", None, [("kind", "side")], "cannot read the filter"),
        ("crashes", None, ("kind", "==", "side"), "cannot read the filter"),
        ("crashes", None, "kind == 'side'", "cannot read the filter"),
        ("crashes", None, {"kind": "side"}, "cannot read the filter"),
        ("crashes", None, [[]], "cannot read the filter"),
        ("crashes", None, [("kind", "in", "side")], "'in' takes a list"),
        ("crashes", None, [("kind", "==", 3)], "column kind of crashes is of type string"),
        ("crashes", None, [("time_s", "<", "3")], "column time_s of crashes is of type float64"),
        ("crashes", None, [("crash_id", "==", 1.5)], "column crash_id of crashes is of type int64"),
        ("crashes", None, [("crash_id", "==", True)], "column crash_id of crashes is of type int64"),
        ("crashes", None, [("secondary", "==", 1)], "column secondary of crashes is of type bool"),
    ],
)
def test_what_cannot_be_read_is_said_with_what_can(stored, kept, table, columns, filters, why):
    for data in (analysis.load(stored), analysis.Dataset.of(kept)):
        with pytest.raises(InputError, match=why) as error:
            data.read(table, columns, filters)
        assert "\n" not in str(error.value)


def test_what_cannot_be_loaded(stored, tmp_path):
    with pytest.raises(InputError, match=r"no results in .*not-there"):
        analysis.load(tmp_path / "not-there")
    with pytest.raises(InputError, match=r"no run in .* matches"):
        analysis.load(stored, filters=[("strategy", "==", "zhao")])
    with pytest.raises(InputError, match="runs has no column 'sead'"):
        analysis.load(stored, filters=[("sead", "==", 1)])
    with pytest.raises(AttributeError, match="no attribute 'crash'"):
        analysis.load(stored).crash  # noqa: B018


def test_every_verdict_can_be_filtered_for(kept):
    data = analysis.Dataset.of(kept)
    counts = {verdict: len(data.read("interventions", [], [("verdict", "==", verdict)])) for verdict in VERDICTS}
    assert sum(counts.values()) == len(data.interventions)


def test_runs_that_died_are_told_apart_and_change_nothing(tmp_path, kept):
    put(kept, tmp_path)
    before = analysis.summary(analysis.load(tmp_path))
    for seed, reason in ((4, "killed"), (5, "hung")):
        commit_failure(tmp_path, {"run_id": f"x-{seed}", "strategy": "zhao2025", "seed": seed, "reason": reason})
    data = analysis.load(tmp_path)
    assert data.died["reason"].tolist() == ["killed", "hung"]
    pd.testing.assert_frame_equal(data.runs, kept.runs)
    pd.testing.assert_frame_equal(analysis.summary(data), before)
    assert len(analysis.pair_counts(data))
    page = render(data)
    assert "2 runs died or hung (hung; killed) and left nothing" in page
    assert "died or hung" not in render(analysis.Dataset.of(kept))
    in_memory = analysis.Dataset.of(read(tmp_path))
    pd.testing.assert_frame_equal(in_memory.died, data.died)
    pd.testing.assert_frame_equal(in_memory.runs, data.runs)


def test_runs_that_all_died_are_no_data_set(tmp_path):
    commit_failure(tmp_path, {"run_id": "a", "reason": "hung"})
    with pytest.raises(InputError, match=r"all 1 runs in .* died: hung"):
        analysis.load(tmp_path)
