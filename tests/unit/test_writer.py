import os
import signal
import subprocess
import sys
import time

import fsspec
import pandas as pd
import pyarrow as pa
import pytest

from aeb_sumo.errors import InputError
from aeb_sumo.results import TABLES, Results, commit_failure, finished, holds_results, read, write
from aeb_sumo.results.writer import ROW_GROUP, Writer

RUN = {"strategy": "none", "outcome": "completed"}


def batch(count, table="conflicts", **row):
    schema = TABLES[table].arrow().remove(0)
    return pa.RecordBatch.from_pylist([row | {"conflict_id": k, "min_ttc_s": k / 7} for k in range(count)], schema)


def files(folder):
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file())


@pytest.fixture(params=["local", "file", "memory"])
def place(request, tmp_path):
    if request.param == "local":
        return str(tmp_path)
    if request.param == "file":
        return f"file://{tmp_path}"
    return f"memory://{tmp_path.name}"


def test_a_run_exists_from_its_commit_on_and_not_before(place):
    with Writer(place, "a") as writer:
        writer.put("conflicts", batch(3))
        writer.put("conflicts", batch(2))
        assert finished(place) == set()
        assert not holds_results(place)
        with pytest.raises(InputError, match="no results in"):
            read(place)
        writer.commit(RUN)
    assert finished(place) == {"a"}
    results = read(place)
    assert results.conflicts["conflict_id"].tolist() == [0, 1, 2, 0, 1]
    assert set(results.conflicts["run_id"]) == set(results.runs["run_id"]) == {"a"}
    assert not len(results.crashes)


def test_what_is_not_committed_leaves_no_file(place):
    with pytest.raises(RuntimeError), Writer(place, "a") as writer:  # noqa: PT012
        writer.put("conflicts", batch(ROW_GROUP + 1))
        raise RuntimeError
    fs, root = fsspec.core.url_to_fs(place)
    assert not fs.find(root)


def test_rows_are_on_disk_long_before_the_end(tmp_path):
    with Writer(tmp_path, "a") as writer:
        for _ in range(4):
            writer.put("conflicts", batch(ROW_GROUP))
        assert (tmp_path / "conflicts" / ".a.parquet.partial").stat().st_size > 100_000


def test_leftovers_of_a_run_that_was_killed_are_ignored_and_overwritten(tmp_path):
    write(Results.of({"runs": [{"run_id": "a"}], "conflicts": [{"run_id": "a"}]}), tmp_path)
    write(Results.of({"runs": [{"run_id": "b"}], "conflicts": [{"run_id": "b"}] * 2}), tmp_path)
    (tmp_path / "runs" / "b.parquet").unlink()
    (tmp_path / "crashes" / ".b.parquet.partial").write_text("half a fi")
    assert finished(tmp_path) == {"a"}
    assert set(read(tmp_path).conflicts["run_id"]) == {"a"}
    with Writer(tmp_path, "b") as writer:
        writer.commit(RUN)
    assert read(tmp_path).conflicts["run_id"].tolist() == ["a"]
    assert not list(tmp_path.rglob("*.partial"))


def test_a_run_that_is_made_again_is_replaced_as_a_whole(place):
    write(Results.of({"runs": [{"run_id": "a", "seed": 1}], "conflicts": [{"run_id": "a"}] * 2}), place)
    write(Results.of({"runs": [{"run_id": "a", "seed": 2}], "crashes": [{"run_id": "a"}]}), place)
    again = read(place)
    assert again.runs["seed"].tolist() == [2]
    assert (len(again.conflicts), len(again.crashes)) == (0, 1)


def test_a_full_disk_is_one_line_and_leaves_nothing(tmp_path):
    folder = tmp_path / "conflicts"
    folder.mkdir()
    (folder / ".a.parquet.partial").symlink_to("/dev/full")
    with pytest.raises(InputError) as error:  # noqa: PT012
        writer = Writer(tmp_path, "a")
        for _ in range(50):
            writer.put("conflicts", batch(ROW_GROUP))
    assert str(error.value) == f"cannot write results into {tmp_path}: No space left on device"
    assert files(tmp_path) == []


def test_a_disk_that_is_full_at_the_end_leaves_nothing_but_the_runs_before(tmp_path):
    write(Results.of({"runs": [{"run_id": "before"}]}), tmp_path)
    kept = files(tmp_path)
    (tmp_path / "traffic" / ".a.parquet.partial").symlink_to("/dev/full")
    with Writer(tmp_path, "a") as writer, pytest.raises(InputError, match="No space left"):
        writer.commit(RUN)
    assert files(tmp_path) == kept


def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=f"cannot write results into {tmp_path}/file: Not a directory"):
        Writer(tmp_path / "file", "a")


@pytest.mark.parametrize("name", ["", ".a", "_a", "a/b", "a*", "a[1]", "a" * 231])
def test_a_run_id_names_a_file(tmp_path, name):
    with pytest.raises(InputError, match="names no file: 1 to 230 bytes"):
        Writer(tmp_path / "new", name)
    assert not (tmp_path / "new").exists()


def test_places_that_do_not_exist():
    for place, why in (("nowhere://x", "nowhere"), ("  ", "is empty")):
        with pytest.raises(InputError, match=why):
            Writer(place, "a")
        with pytest.raises(InputError, match=why):
            finished(place)
    assert finished("memory://not-there") == set()


_WRITE_ON = """
import sys
from tests.unit.test_writer import *
with Writer(sys.argv[1], "killed") as writer:
    while True:
        writer.put("conflicts", batch(ROW_GROUP))
        print(flush=True)
"""


def test_a_killed_writer_leaves_no_run(tmp_path):
    write(Results.of({"runs": [{"run_id": "before"}]}), tmp_path)
    with subprocess.Popen([sys.executable, "-c", _WRITE_ON, str(tmp_path)], stdout=subprocess.PIPE) as process:
        process.stdout.readline()
        process.send_signal(signal.SIGKILL)
    assert (tmp_path / "conflicts" / ".killed.parquet.partial").exists()
    assert finished(tmp_path) == {"before"}
    assert len(read(tmp_path).conflicts) == 0


def test_a_fork_writes_nothing_into_the_run(tmp_path):
    with Writer(tmp_path, "a") as writer:
        writer.put("conflicts", batch(3))
        if (child := os.fork()) == 0:
            for _ in range(3):
                writer.put("conflicts", batch(ROW_GROUP))
            writer.discard()
            os._exit(0)
        os.waitpid(child, 0)
        writer.put("conflicts", batch(1))
        writer.commit(RUN)
    assert read(tmp_path).conflicts["conflict_id"].tolist() == [0, 1, 2, 0]


def test_a_failure_is_a_row_and_nothing_else(place):
    commit_failure(place, {"run_id": "dead", "strategy": "zhao2025", "seed": 3, "reason": "hung for 60 s"})
    (row,) = read(place).runs.to_dict("records")
    assert (row["run_id"], row["outcome"], row["reason"]) == ("dead", "failed", "hung for 60 s")
    assert all(len(read(place).frame(name)) == (name == "runs") for name in TABLES)


@pytest.mark.parametrize(
    ("row", "why"),
    [
        ({"run_id": "a", "sead": 1}, "no column 'sead'; there are: run_id, scenario"),
        ({"seed": 1}, "needs its run_id"),
        ({"run_id": "a", "seed": "one"}, "a value of another type"),
    ],
)
def test_a_failure_that_is_no_row(tmp_path, row, why):
    with pytest.raises(InputError, match=why):
        commit_failure(tmp_path, row)
    assert files(tmp_path) == []


def test_ten_thousand_runs_are_counted_at_once(tmp_path):
    (tmp_path / "runs").mkdir()
    for k in range(10_000):
        (tmp_path / "runs" / f"run-{k}.parquet").touch()
    begin = time.perf_counter()
    assert len(finished(tmp_path)) == 10_000
    assert time.perf_counter() - begin < 2


def test_a_tilde_is_a_name_like_any_other(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    commit_failure("~", {"run_id": "a"})
    assert finished("~") == {"a"}
    assert len(read("~").runs) == 1
    assert (tmp_path / "~" / "runs" / "a.parquet").exists()


def test_the_files_are_what_pandas_reads(tmp_path):
    with Writer(tmp_path, "a") as writer:
        writer.put("conflicts", batch(ROW_GROUP + 5, kind="crossing"))
        writer.commit(RUN)
    frame = pd.read_parquet(tmp_path / "conflicts")
    assert len(frame) == ROW_GROUP + 5
    assert set(frame["kind"]) == {"crossing"}
