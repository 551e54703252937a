"""The grid in SUMO, a few cells of it."""

import json
from dataclasses import dataclass, replace

import pytest
from click.testing import CliRunner

from aeb_sumo import ncap as grid
from aeb_sumo import strategies
from aeb_sumo.cli.ncap import ncap
from aeb_sumo.errors import InputError
from aeb_sumo.ncap import Cell, run_grid
from aeb_sumo.units import KMH


@dataclass(frozen=True, order=True)
class Broken(Cell):
    """A cell whose network is not there."""

    def scenario(self, mu=grid.MU):
        return replace(super().scenario(mu), options=("--net-file", "nowhere.net.xml"))


def test_without_aeb_the_car_hits_the_target_at_the_test_speed_and_a_broken_cell_loses_no_other():
    cells = (
        Broken("ccrs", 1.0, 30),
        Cell("ccrs", 0.5, 40),
        Cell("ccrm", 1.0, 60),
        Cell("ccrb", 1.0, 50),
    )
    calls = []
    rows = run_grid(strategies.load("none"), cells=cells, workers=2, done=lambda: calls.append(1))
    assert len(calls) == len(cells)
    assert rows["error"].str.contains("nowhere.net.xml").tolist() == [True] + 3 * [False]
    ran = rows.iloc[1:]
    assert (ran["euroncap_colour"] == "red").all()
    assert ran["contact"].all()
    assert ran["impact_speed_kmh"].iloc[:2].tolist() == pytest.approx([40, 40], abs=0.01)
    # CCRb: 1 s ahead, from 4 m/s2, is used up when the closing speed is sqrt(2 * 4 * gap).
    assert ran["impact_speed_kmh"].iloc[2] == pytest.approx((2 * 4.0 * 50 * KMH) ** 0.5 / KMH, abs=0.4)
    assert ran["peak_decel_mps2"].tolist() == [0, 0, 0]
    assert ran["min_gap_m"].tolist() == [0, 0, 0]
    assert ran["warning_ttc_s"].isna().all()


def test_the_command_prints_the_grid_and_its_json_holds_the_same_rows(monkeypatch, tmp_path):
    monkeypatch.setattr(grid, "GRID", tuple(Cell("ccrs", 1.0, speed) for speed in (20, 40)))
    done = CliRunner().invoke(ncap, ["zhao2025", "--workers", "1", "--json", str(tmp_path / "rows.json")])
    assert done.exception is None, done.output
    line = next(each for each in done.output.splitlines() if "CCRs 100 %" in each)
    assert line.replace("│", " ").split() == ["CCRs", "100", "%", "G", "G", "100", "100", "2/2", "-"]
    records = json.loads((tmp_path / "rows.json").read_text())
    assert [r["test_speed_kmh"] for r in records] == [20, 40]
    assert [(r["contact"], r["impact_speed_kmh"], r["euroncap_colour"]) for r in records] == [
        (False, None, "green")
    ] * 2
    for r in records:
        # The source's own figures (seeds 1, Table 7 ff.): warnings from a TTC of 2.6 s on, gaps of 0.9 to 1.5 m.
        assert 2.4 < r["warning_ttc_s"] < 2.8
        assert 0.6 < r["min_gap_m"] < 2.0
        assert r["windows_passed"] is None


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["magic"], ["magic", "zhao2025"]),
        (["zhao2025", "--sensing", "sonar"], ["sonar", "fusion"]),
        (["zhao2025", "--set", "magic=1"], ["magic", "brake"]),
        (["zhao2025", "--set", "magic"], ["NAME=VALUE"]),
        (["zhao2025", "--params", "nowhere.toml"], ["nowhere.toml"]),
        (["zhao2025", "--mu", "nan"], ["mu", "nan"]),
        (["zhao2025", "--json", "nowhere/rows.json"], ["nowhere/rows.json"]),
    ],
)
def test_bad_input_is_told_before_anything_runs(arguments, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(ncap, arguments)
    assert isinstance(done.exception, InputError)
    for word in words:
        assert word in str(done.exception)
    assert done.output == ""
