"""aeb-sumo plan: what a campaign will cost and tell."""

import re

import pytest

import analysis
from aeb_sumo.campaign import journal
from tests.helpers import SMALL_CAMPAIGN, command


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A campaign of two seeds in `out`, its specification beside it."""
    folder = tmp_path_factory.mktemp("campaign")
    (folder / "spec.toml").write_text(SMALL_CAMPAIGN.format(seeds="[1, 2]"))
    done = command("campaign", folder / "spec.toml", "--out", folder / "out", "--quiet")
    assert done.returncode == 0, done.stderr
    return folder


def test_pilot_runs_tell_cost_and_traffic_and_leave_nothing(tmp_path):
    (tmp_path / "spec.toml").write_text(SMALL_CAMPAIGN.format(seeds="'1..100'"))
    done = command("plan", "spec.toml", "--pilot", 4, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    words = " ".join(done.stdout.split())
    assert "track-none-p0" in words
    assert "200 runs, 200 to do" in words
    assert "2 rows are based on one pilot run each, of 4 s or the whole run if that is shorter, with 0 crashes" in words
    assert "a guess" in words
    hours, km = re.search(r"to do: ([\d.,]+) core-hours.* ([\d.,]+) vehicle-km in all", words).groups()
    assert 0.001 < float(hours) < 1
    assert 1 < float(km.replace(",", "")) < 100
    assert [path.name for path in tmp_path.iterdir()] == ["spec.toml"]


def test_runs_that_are_there_are_better_than_pilot_runs(folder, tmp_path):
    out = folder / "out"
    (tmp_path / "spec.toml").write_text(SMALL_CAMPAIGN.format(seeds="'1..10'"))
    done = command("plan", tmp_path / "spec.toml", "--have", out)
    assert done.returncode == 0, done.stderr
    words = " ".join(done.stdout.split())
    assert "20 runs, 4 of them there, 16 to do" in words
    assert "2 rows are based on 4 runs that are there." in words
    assert "pilot" not in words
    hours, km = re.search(r"to do: ([\d.e-]+) core-hours.*?([\d.,]+) vehicle-km in all", words).groups()
    spent = [each.cpu_s for each in journal.spent(str(out)).values()]
    assert len(spent) == 4
    assert float(hours) == pytest.approx(sum(spent) / 4 * 16 / 3600, rel=0.01)
    data = analysis.load(out)
    assert float(km) == pytest.approx(5 * data.traffic["distance_m"].sum() / 1000, rel=0.01)
    crashes = len(data.crashes[data.crashes["run_id"].str.contains("none")])
    assert re.search(rf"track-none-p0 │ 10 │ [\d.]+ │ [\d.]+ │ {5 * crashes} │", words), words


def test_runs_that_were_shorter_are_scaled_and_said_to_be(folder, tmp_path):
    (tmp_path / "spec.toml").write_text(SMALL_CAMPAIGN.format(seeds="[1, 2]").replace("= 8", "= 80"))
    done = command("plan", tmp_path / "spec.toml", "--have", folder / "out")
    assert done.returncode == 0, done.stderr
    assert "4 runs, 4 to do" in done.stdout
    assert "Some of them are shorter than those to come" in done.stdout
    km = float(re.search(r"([\d.,]+) vehicle-km in all", done.stdout)[1])
    assert km == pytest.approx(10 * analysis.load(folder / "out").traffic["distance_m"].sum() / 1000, rel=0.01)


def test_what_runs_do_not_tell_is_piloted(folder, tmp_path):
    (tmp_path / "spec.toml").write_text(SMALL_CAMPAIGN.format(seeds="1").replace('"none", ', '"none", "yan2025", '))
    done = command("plan", tmp_path / "spec.toml", "--have", folder / "out", "--pilot", 2)
    assert done.returncode == 0, done.stderr
    words = " ".join(done.stdout.split())
    assert "2 rows are based on 4 runs that are there. 1 rows are based on one pilot run each" in words


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (("--have", "nowhere"), "--have nowhere holds no campaign"),
        (("--pilot", "0.9"), "--pilot must be 1 seconds or more, not 0.9"),
        (("--pilot", "nan"), "--pilot must be 1 seconds or more, not nan"),
    ],
)
def test_bad_options_are_one_line(tmp_path, arguments, reason):
    (tmp_path / "spec.toml").write_text(SMALL_CAMPAIGN.format(seeds="1"))
    done = command("plan", "spec.toml", *arguments, cwd=tmp_path)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert reason in line


def test_a_pilot_run_that_sumo_refuses_is_one_line(tmp_path):
    import sumo_nets

    net = sumo_nets.folder("track") / "track.net.xml"
    (tmp_path / "bad.rou.xml").write_text(
        '<routes><vehicle id="v" depart="0"><route edges="nowhere"/></vehicle></routes>'
    )
    (tmp_path / "bad.sumocfg").write_text(
        f'<configuration><net-file value="{net}"/><route-files value="bad.rou.xml"/><end value="5"/></configuration>'
    )
    (tmp_path / "spec.toml").write_text('[factors]\nscenario = "bad.sumocfg"\nstrategy = "none"\n')
    done = command("plan", "spec.toml", cwd=tmp_path)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "the pilot run bad-none-p0" in line
    assert "nowhere" in line
