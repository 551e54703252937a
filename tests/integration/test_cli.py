"""The command as a user types it."""

import hashlib
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest

from aeb_sumo.results import TABLES
from tests.helpers import command


def fingerprint(folder: Path) -> dict[str, str]:
    return {
        str(p.relative_to(folder)): hashlib.sha256(p.read_bytes()).hexdigest() for p in folder.rglob("*") if p.is_file()
    }


def test_compare_prints_both_and_keeps_the_tables(tmp_path):
    done = command("run", "track", "--compare", "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    for word in ("none", "zhao2025", "difference", "rear end", "crash rate", "override violations"):
        assert word in done.stdout
    for name in TABLES:
        pd.read_parquet(tmp_path / "out" / name)
    assert sorted(pd.read_parquet(tmp_path / "out" / "runs")["strategy"]) == ["none", "zhao2025"]
    again = command("compare", tmp_path / "out")
    assert again.returncode == 0
    for word in ("difference", "what became of the crashes", "price for the traffic"):
        assert word in " ".join(again.stdout.split())


def test_the_same_command_twice_gives_identical_tables(tmp_path):
    for name in ("a", "b"):
        assert command("run", "highway", "--duration", 60, "--out", tmp_path / name, "--quiet").returncode == 0
    assert fingerprint(tmp_path / "a") == fingerprint(tmp_path / "b")


def test_a_mix_is_one_run_beside_the_baseline(tmp_path):
    mix = ("--equip", "zhao2025=0.5,yan2025=0.5", "--set", "zhao2025.comfort_decel=5", "--set", "yan2025.brake.lag=0.2")
    done = command("run", "track", *mix, "--compare", "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    runs = pd.read_parquet(tmp_path / "out" / "runs").set_index("strategy")
    assert sorted(runs.index) == ["none", "yan2025=0.5,zhao2025=0.5"]
    row = runs.loc["yan2025=0.5,zhao2025=0.5"]
    assert row["sensing"] == "fusion+ideal"
    assert row["parameters"] == "yan2025.brake.lag=0.2 zhao2025.comfort_decel=5.0"
    assert row["penetration"] == 1
    assert command("compare", tmp_path / "out").returncode == 0


def test_ceilings_are_printed_and_kept(tmp_path):
    done = command("run", "track", "--compare", "--ceilings", "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert "crashes of the baseline avoided by" in done.stdout
    table = pd.read_parquet(tmp_path / "out" / "ceilings").set_index("ceiling")
    assert sorted(table.index) == ["careful", "perfect", "zhao2025"]
    assert set(table["outcome"]) == {"avoided"}
    plain = tmp_path / "plain"
    assert command("run", "track", "--compare", "--out", plain, "--quiet").returncode == 0
    for name in set(TABLES) - {"ceilings"}:
        assert pd.read_parquet(tmp_path / "out" / name).equals(pd.read_parquet(plain / name)), name
    assert pd.read_parquet(plain / "ceilings").empty


def test_quiet_is_quiet(tmp_path):
    done = command("run", "track", "--quiet")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_tables_are_documented():
    done = command("tables", "crashes")
    assert done.returncode == 0
    assert "impact_speed_mps" in done.stdout


BAD = [
    (("run", "nowhere"), ["nowhere", "221, 321, 322, 601, b2, highway, track, w0, w1, w2, w2t"]),
    (("run", "highway", "--ebike-share", "0.5"), ["highway", "no share of e-bikes", "b2, w0, w1, w2, w2t"]),
    (("run", "w0", "--ebike-share", "2"), ["ebike_share", "0 .. 1", "2"]),
    (("run", "w0", "--demand", "-1"), ["demand", "positive", "-1"]),
    (("run", "w0", "--weather", "snow"), ["weather", "dry, wet", "snow"]),
    (("run",), ["SCENARIO", "--sumocfg"]),
    (("run", "w0", "--sumocfg", "x.sumocfg"), ["SCENARIO", "--sumocfg"]),
    (("run", "highway", "--strategy", "magic"), ["magic", "none, perfect, staged, staged_m, yan2025, zhao2025"]),
    (("run", "highway", "--compare", "--strategy", "none"), ["--compare", "none"]),
    (("run", "highway", "--ceilings", "--strategy", "yan2025"), ["--ceilings", "none", "--compare"]),
    (("run", "highway", "--drivers", "drunk"), ["drunk", "attentive, careful"]),
    (("run", "highway", "--magic"), ["--magic", "--penetration"]),
    (("run", "highway", "--penetration", "1.5"), ["penetration", "0..1", "1.5"]),
    (("run", "highway", "--penetration", "nan"), ["penetration", "0..1"]),
    (("run", "highway", "--equip", "zhao2025=0.8,yan2025=0.5"), ["cars", "1.3", "zhao2025=0.8"]),
    (("run", "highway", "--equip", "zhao2025=1.5"), ["zhao2025", "0..1", "1.5"]),
    (("run", "highway", "--equip", "zhao2025=lots"), ["zhao2025", "0..1", "lots"]),
    (("run", "highway", "--equip", "magic=0.5"), ["magic", "zhao2025"]),
    (("run", "highway", "--equip", "zhao2025/sonar=0.5"), ["sonar", "radar"]),
    (("run", "highway", "--equip", "zhao2025"), ["zhao2025", "SYSTEM", "=SHARE"]),
    (("run", "highway", "--equip", "truk:zhao2025=1"), ["truk", "vehicle type"]),
    (("run", "highway", "--equip", "zhao2025=1", "--strategy", "yan2025"), ["equip", "strategy"]),
    (("run", "highway", "--equip", "zhao2025=1", "--penetration", "0.5"), ["equip", "penetration"]),
    (("run", "highway", "--equip", "zhao2025=1", "--sensing", "radar"), ["equip", "sensing"]),
    (("run", "highway", "--equip", "zhao2025=1", "--set", "brake.lag=0.2"), ["brake.lag", "zhao2025"]),
    (("run", "highway", "--duration", "-1"), ["duration", "positive", "-1"]),
    (("run", "highway", "--duration", "0"), ["duration", "positive"]),
    (("run", "highway", "--duration", "ten"), ["duration", "ten"]),
    (("run", "highway", "--step-length", "0"), ["step length", "positive"]),
    (("run", "highway", "--step-length", "-0.1"), ["step length", "positive"]),
    (("run", "highway", "--seed", "-3"), ["seed"]),
    (("run", "highway", "--blockage", "-3"), ["blockage"]),
    (("run", "--sumocfg", "missing.sumocfg"), ["missing.sumocfg"]),
    (("run", "--sumocfg", "broken.sumocfg"), ["broken.sumocfg", "XML"]),
    (("run", "--sumocfg", "no_net.sumocfg"), ["nowhere.net.xml"]),
    (("run", "--sumocfg", "bad_net.sumocfg"), ["bad.net.xml", "well-formed"]),
    (("run", "--sumocfg", "cut_routes.sumocfg"), ["cut.rou.xml", "well-formed"]),
    (("run", "--sumocfg", "no_routes.sumocfg"), ["nowhere.rou.xml"]),
    (("run", "--sumocfg", "bad_routes.sumocfg"), ["SUMO"]),
    (("run", "track", "--out", "results"), ["results", "already holds results"]),
    (("run", "track", "--out", ""), ["--out", "empty"]),
    (("run", "track", "--out", "broken.sumocfg"), ["broken.sumocfg", "file"]),
    (("compare", "nothing"), ["nothing", "no results"]),
    (("tables", "nothing"), ["nothing", "crashes"]),
    (("fly",), ["fly", "run"]),
]


@pytest.mark.parametrize(("arguments", "words"), BAD, ids=[" ".join(a) for a, _ in BAD])
def test_bad_input_is_one_clear_line(arguments, words, tmp_path):
    import sumo_nets

    track = sumo_nets.folder("track") / "track.net.xml"
    (tmp_path / "broken.sumocfg").write_text("<configuration><net-file")
    (tmp_path / "bad.net.xml").write_text("<net><edge")
    (tmp_path / "bad.rou.xml").write_text(
        '<routes><vehicle id="v" depart="0"><route edges="nowhere"/></vehicle></routes>'
    )
    (tmp_path / "cut.rou.xml").write_text("<routes><vehicle")
    for name, net, routes in (
        ("no_net", "nowhere.net.xml", ""),
        ("bad_net", "bad.net.xml", ""),
        ("no_routes", track, "nowhere.rou.xml"),
        ("bad_routes", track, "bad.rou.xml"),
        ("cut_routes", track, "cut.rou.xml"),
    ):
        extra = f'<route-files value="{routes}"/>' if routes else ""
        (tmp_path / f"{name}.sumocfg").write_text(f'<configuration><net-file value="{net}"/>{extra}</configuration>')
    (tmp_path / "results" / "runs").mkdir(parents=True)
    (tmp_path / "results" / "runs" / "a.parquet").write_text("precious")
    before = fingerprint(tmp_path)
    out = () if "--out" in arguments or arguments[0] != "run" else ("--out", "new")
    done = command(*arguments, *out, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stdout == ""
    (line,) = done.stderr.splitlines()
    for word in words:
        assert word in line
    assert "Process Error" not in line
    assert "Traceback" not in line
    assert fingerprint(tmp_path) == before
    assert not (tmp_path / "new").exists()


def test_ctrl_c_leaves_complete_tables_marked_as_interrupted(tmp_path):
    out = tmp_path / "out"
    process = subprocess.Popen(
        [sys.executable, "-m", "aeb_sumo", "run", "highway", "--duration", "3600", "--out", str(out), "--quiet"]
    )
    deadline = time.monotonic() + 60
    while not (out / "sumo").exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    time.sleep(3)
    process.send_signal(signal.SIGINT)
    assert process.wait(60) == 130
    tables = {name: pd.read_parquet(out / name) for name in TABLES}
    row = tables["runs"].iloc[0]
    assert row["outcome"] == "interrupted"
    assert 0 < row["end_s"] < 3600
    assert tables["exposure"]["time_s"].sum() > 0
    assert not list(out.rglob("*.partial"))


def test_a_scenario_of_the_users_own_runs_untouched(bologna, tmp_path):
    before = fingerprint(bologna)
    done = command("run", "--sumocfg", bologna / "run.sumocfg", "--duration", 60, "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert fingerprint(bologna) == before
    runs = pd.read_parquet(tmp_path / "out" / "runs").iloc[0]
    exposure = pd.read_parquet(tmp_path / "out" / "exposure")
    assert runs["step_length_s"] == pytest.approx(0.1)
    assert runs["seed"] == 23423, "SUMO's own default: the configuration does not say"
    assert runs["drivers"] == "sumo"
    assert runs["override_violations"] == 0
    assert exposure.loc[exposure["vclass"].isin(["passenger", "ignoring"]), "equipped"].all()
    assert not exposure.loc[exposure["vclass"] == "bus", "equipped"].any()
    outputs = {p.name for p in (tmp_path / "out" / "sumo" / "zhao2025").iterdir()}
    assert {"tripinfos.xml", "sumo_log.txt", "e1_output.xml"} <= outputs


def test_its_own_time_span_is_respected(tmp_path):
    import sumo_nets

    net = sumo_nets.folder("track") / "track.net.xml"
    (tmp_path / "r.rou.xml").write_text('<routes><trip id="t" depart="105" from="track" to="track"/></routes>')
    (tmp_path / "x.sumocfg").write_text(
        f'<configuration><net-file value="{net}"/><route-files value="r.rou.xml"/>'
        '<begin value="100"/><end value="130"/><step-length value="0.5"/><seed value="7"/></configuration>'
    )
    assert command("run", "--sumocfg", "x.sumocfg", "--out", "out", "--quiet", cwd=tmp_path).returncode == 0
    row = pd.read_parquet(tmp_path / "out" / "runs").iloc[0]
    assert (row["begin_s"], row["end_s"], row["step_length_s"], row["seed"]) == (100, 130, 0.5, 7)


def test_results_go_to_a_url_and_come_from_it(tmp_path):
    place = f"file://{tmp_path}/out"
    done = command("run", "track", "--compare", "--duration", 10, "--out", place)
    assert done.returncode == 0, done.stderr
    assert len(pd.read_parquet(tmp_path / "out" / "runs")) == 2
    assert command("compare", place).returncode == 0
    done = command("report", place, "--out", tmp_path / "page.html")
    assert done.returncode == 0, done.stderr
    done = command("report", "memory://nothing")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "--out is missing" in done.stderr
    done = command("run", "track", "--out", "nowhere://x")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "nowhere://x" in done.stderr


def test_help_names_every_command_without_importing_any():
    code = "import sys, runpy\nsys.argv = ['aeb-sumo']\ntry:\n    runpy.run_module('aeb_sumo')\nfinally:\n"
    code += "    print({'numpy', 'libsumo', 'numba'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    *told, imported = done.stdout.splitlines()
    assert imported == "set()"
    listed = [line.split()[0] for line in told[told.index("Commands:") + 1 :]]
    assert len(listed) == 14
    assert max(map(len, told)) < 80
    for name in listed:
        assert f"aeb-sumo {name} [OPTIONS]" in " ".join(command(name, "--help").stdout.split())
