import subprocess
import sys

import pandas as pd
import pytest

from aeb_sumo import scenarios
from aeb_sumo.errors import InputError
from aeb_sumo.ledger.crashes import Crashes
from aeb_sumo.results import TABLES, finished, read
from aeb_sumo.simulate import run

RUNS = {
    "w0": {"strategy": "zhao2025", "duration": 120, "seed": 3},
    "highway": {"strategy": "zhao2025", "duration": 45, "verdicts": "all", "interval": 5.0},
    "track": {"strategy": "none", "duration": 20, "blockage": 2},
}
HAS = {"w0": ["conflicts"], "highway": ["interventions"], "track": ["crashes"]}


@pytest.mark.parametrize("name", RUNS)
def test_streamed_tables_are_those_in_memory(tmp_path, name):
    kept = run(scenarios.load(name), **RUNS[name])
    told = run(scenarios.load(name), **RUNS[name], out=str(tmp_path))
    streamed = read(tmp_path)
    assert streamed.runs["run_id"].tolist() == kept.runs["run_id"].tolist()
    for table in TABLES:
        pd.testing.assert_frame_equal(streamed.frame(table), kept.frame(table))
        assert len(told.frame(table)) == (table == "runs")
    pd.testing.assert_frame_equal(told.runs, kept.runs)
    assert all(len(kept.frame(table)) for table in ("traffic", "exposure", *HAS[name]))


def test_a_crash_is_written_down_when_one_of_the_two_has_left_and_with_what_sumo_said_until_then():
    waits = []
    book = Crashes(*[None] * 3)
    book._fresh.extend({"striker": f"b{k}", "struck": f"a{k}"} for k in range(4))
    for gone in ({"c"}, {"a1"}, {"b0"}, {"a2", "b2"}):
        book.reconcile({("a1", "b1"), ("a2", "b2")}, gone)
        waits.append(len(book.rows))
    book.reconcile(set())
    assert [*waits, len(book.rows)] == [0, 0, 2, 3, 4]
    assert book.rows.of_run("x")["sumo_reported"].to_pylist() == [False, True, True, False]
    assert book.confirmed == 2


_LONG = """
import sys
from aeb_sumo.scenarios import load
from aeb_sumo.simulate import run
run(load("highway"), duration=1e4, out=sys.argv[1], run_id="killed", progress=lambda now: print(flush=True))
"""


def test_a_run_that_is_killed_is_none_and_can_be_made_again(tmp_path):
    run(scenarios.load("track"), "none", duration=2, out=str(tmp_path), run_id="before")
    with subprocess.Popen([sys.executable, "-c", _LONG, str(tmp_path)], stdout=subprocess.PIPE) as process:
        process.stdout.readline()
        process.kill()
    assert list(tmp_path.rglob("*killed*"))
    assert read(tmp_path).runs["run_id"].tolist() == ["before"]
    run(scenarios.load("track"), "none", duration=2, out=str(tmp_path), run_id="killed")
    assert finished(tmp_path) == {"before", "killed"}
    assert not list(tmp_path.rglob("*.partial"))


def test_a_disk_that_fills_up_ends_the_run_with_one_line(tmp_path):
    (tmp_path / "traffic").mkdir()
    (tmp_path / "traffic" / ".a.parquet.partial").symlink_to("/dev/full")
    with pytest.raises(InputError, match=f"^cannot write results into {tmp_path}: No space left on device$"):
        run(scenarios.load("track"), "none", duration=2, out=str(tmp_path), run_id="a", verdicts="all")
    assert not [p for p in tmp_path.rglob("*") if not p.is_dir()]


def test_a_run_can_be_given_a_name(tmp_path):
    run(scenarios.load("track"), "none", duration=2, out=str(tmp_path), run_id="mine")
    assert finished(tmp_path) == {"mine"}
    assert set(read(tmp_path).exposure["run_id"]) == {"mine"}


def test_a_run_that_is_left_by_an_exception_leaves_no_file(tmp_path):
    def bail(_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(scenarios.load("track"), "none", duration=2, out=str(tmp_path), progress=bail)
    assert not [p for p in tmp_path.rglob("*") if p.is_file()]


def test_an_interrupted_run_is_there_with_its_outcome(tmp_path):
    steps = iter(range(99))
    run(scenarios.load("track"), "none", duration=5, out=str(tmp_path), stop=lambda: next(steps) == 9)
    assert read(tmp_path).runs["outcome"].tolist() == ["interrupted"]


def test_bad_input_leaves_no_folder(tmp_path):
    with pytest.raises(InputError):
        run(scenarios.load("track"), "none", duration=5, blockage=1e9, out=str(tmp_path / "new"))
    assert not (tmp_path / "new").exists()
