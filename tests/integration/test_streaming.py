import pandas as pd
import pytest

from aeb_sumo import scenarios
from aeb_sumo.errors import InputError
from aeb_sumo.results import TABLES, finished, read
from aeb_sumo.simulate import run

RUNS = {
    "w0": {"strategy": "zhao2025", "duration": 200, "seed": 3},
    "highway": {"strategy": "zhao2025", "duration": 45, "verdicts": "all", "interval": 5.0},
}


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
    assert len(kept.traffic)
    assert len(kept.interventions)


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
