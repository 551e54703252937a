"""`aeb-sumo calibrate` and `aeb-sumo drivers`."""

import pytest

from aeb_sumo.drivers import profile
from tests.helpers import command


def test_the_drivers_of_the_highway_beside_the_evidence(tmp_path):
    done = command("calibrate", "--seeds", 2, "--duration", 40, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    for words in (
        "near-crashes per crash",
        "9.3 (100-Car)",
        "glance, median [s]",
        "alpha, median",
        "time gap of followers",
    ):
        assert words in done.stdout
    assert not list(tmp_path.iterdir())


def test_the_sweep_draws_its_figure(tmp_path):
    done = command("calibrate", "--sweep", "--seeds", 1, "--duration", 15, "--figure", "f.svg", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "0.45" in done.stdout
    assert "<svg" in (tmp_path / "f.svg").read_text()


def test_profiles_are_printed_as_they_are(tmp_path):
    done = command("drivers", "highway", cwd=tmp_path)
    assert done.stdout == profile.text("highway")
    names = command("drivers", cwd=tmp_path).stdout
    assert all(name in names for name in profile.names())


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("calibrate", "--drivers", "drunk"), "unknown driver profile 'drunk'"),
        (("calibrate", "--drivers", "careful", "--fit"), "careful has no section [hard_braking]"),
        (("calibrate", "--duration", "0"), "duration must be a positive number"),
        (("calibrate", "--duration", "nan"), "duration must be a positive number"),
        (("calibrate", "--seeds", "0"), "seeds"),
        (("calibrate", "--fit", "--sweep"), "--fit and --sweep are two runs"),
        (("calibrate", "--out", "new.toml"), "--out new.toml"),
        (("calibrate", "--fit", "--out", "no/new.toml"), "existing folder"),
        (("calibrate", "--fit", "--out", "new.toml", "--drivers", "inline.toml"), "write it as [hard_braking]"),
        (("calibrate", "--sweep", "--figure", "f.gif"), "--figure f.gif"),
        (("drivers", "drunk"), "unknown driver profile 'drunk'"),
        (("drivers", "bad.toml"), "Glances.share must be within 0 .. 0.9, not 2"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_bad_input_is_one_clear_line(arguments, words, tmp_path):
    (tmp_path / "bad.toml").write_text("[glances]\nshare = 2\n")
    (tmp_path / "inline.toml").write_text("hard_braking = {duration = 1.0}\n")
    before = sorted(tmp_path.iterdir())
    done = command(*arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stdout == ""
    (line,) = done.stderr.splitlines()
    assert words in line
    assert sorted(tmp_path.iterdir()) == before
