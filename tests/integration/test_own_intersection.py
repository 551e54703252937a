"""`aeb-sumo intersection` as a user types it."""

import os
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

from tests.helpers import command
from tests.integration.test_networks import HAS_NETCONVERT

needs_netconvert = pytest.mark.skipif(not HAS_NETCONVERT, reason="netconvert is not installed (extra: dev)")


@needs_netconvert
def test_an_intersection_from_a_file_and_the_command_line_can_be_run(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text('arms = "new"\nlanes = 2\nmedian = 2.0\nsetback = 4.0\n[demand]\nflow = 900\nebike_share = 0.4\n')
    built = command("intersection", file, "--set", "median=3.0", "--set", "demand.left=0.3", "--out", tmp_path / "x")
    assert built.returncode == 0, built.stderr
    assert f"offset {1.4 + 3.0 + 5.6 + 0.6:.2f} m" in built.stdout
    sumocfg = tmp_path / "x" / "intersection.sumocfg"
    assert str(sumocfg) in built.stdout
    done = command(
        "run", "--sumocfg", sumocfg, "--duration", 60, "--weather", "wet", "--demand", 2, "--out", tmp_path / "out"
    )
    assert done.returncode == 0, done.stderr
    runs = pd.read_parquet(tmp_path / "out" / "runs").iloc[0]
    assert (runs["demand"], runs["weather"], runs["mu"]) == (2.0, "wet", 0.5)
    assert runs["vehicles"] > 10


def test_the_variation_is_in_the_tables(tmp_path):
    done = command(
        "run", "w2t", "--strategy", "none", "--duration", 30, "--ebike-share", 0, "--mu", 0.4, "--out", tmp_path / "out"
    )
    assert done.returncode == 0, done.stderr
    runs = pd.read_parquet(tmp_path / "out" / "runs").iloc[0]
    assert (runs["demand"], runs["ebike_share"], runs["weather"], runs["mu"]) == (1.0, 0.0, "", 0.4)
    assert set(pd.read_parquet(tmp_path / "out" / "exposure")["vclass"]) == {"passenger"}


BAD = [
    (("--set", "median=-1"), ["median", "0 .. 30", "-1"]),
    (("--set", "turn_radius=10", "--set", "lanes=4"), ["turn_radius 10 m does not fit", "stop line"]),
    (("--set", "lane=2"), ["no parameter 'lane'", "lanes, lane_width"]),
    (("--set", "lanes=two"), ["lanes", "a whole number", "two"]),
    (("--set", "demand.flows=2"), ["no parameter 'flows'", "flow, ebike_share"]),
    (("--set", "demand=2"), ["demand must be a table", "2"]),
    (("--set", "demand.ebike_share=1.5"), ["ebike_share", "0 .. 1", "1.5"]),
    (("no.toml",), ["no.toml"]),
]


@pytest.mark.parametrize(("arguments", "words"), BAD)
def test_bad_input_is_one_line_and_nothing_is_written(arguments, words, tmp_path):
    done = command("intersection", *arguments, "--out", tmp_path / "x", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert all(word in done.stderr for word in words), done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_holds_something_is_refused(tmp_path):
    (tmp_path / "note.txt").write_text("mine")
    done = command("intersection", "--out", tmp_path)
    assert done.returncode == 2
    assert "is not empty" in done.stderr
    assert [p.name for p in tmp_path.iterdir()] == ["note.txt"]


def test_without_netconvert_the_extra_is_named(tmp_path):
    code = "import shutil; shutil.which = lambda *a, **k: None; from aeb_sumo.cli import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", code, "intersection", "--out", str(tmp_path / "x")],
        capture_output=True, text=True, check=False, env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])},
    )  # fmt: skip
    assert done.returncode == 2
    assert "pip install 'aeb-sumo[nets]'" in done.stderr
    assert not (tmp_path / "x").exists()
