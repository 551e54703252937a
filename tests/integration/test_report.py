"""The report of runs that were really made: every number by hand, and the page in a browser."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.stats import chi2

import analysis
import sumo_nets
from aeb_sumo import scenarios
from aeb_sumo.cli.report import _networks, report
from aeb_sumo.drivers.profile import ROBOTS
from aeb_sumo.errors import InputError
from aeb_sumo.results import VERDICTS, write
from aeb_sumo.scenarios import Scenario
from aeb_sumo.simulate import run
from analysis.report import render
from tests.helpers import vehicle
from tests.pages import Page

SEEDS = range(1, 21)
NET = sumo_nets.folder("track") / "track.net.xml"


@pytest.fixture(scope="module")
def comparison(tmp_path_factory):
    """20 seeds without and with every second car equipped: two cars at random speeds, each behind one that stands."""
    cars = "".join(
        vehicle(f"lead{k}", 340.0 * k + 60, 0) + vehicle(f"ego{k}", 340.0 * k, 0).replace('Speed="0"', 'Speed="random"')
        for k in (1, 2)
    )
    routes = tmp_path_factory.mktemp("routes") / "track.rou.xml"
    routes.write_text(
        f'<routes><vType id="car" vClass="passenger" length="4.6" width="1.82" sigma="0" speedDev="0" maxSpeed="25"/>'
        f'<route id="r" edges="track"/>{cars}</routes>'
    )
    scenario = Scenario(name="twice", options=("-n", str(NET), "-r", str(routes)), drivers=ROBOTS, duration=7.0)
    folder = tmp_path_factory.mktemp("results")
    for seed in SEEDS:
        write(run(scenario, "none", seed=seed, interval=2.0), folder)
        write(run(scenario, "zhao2025", penetration=0.5, seed=seed, interval=2.0, verdicts="all"), folder)
    return folder


@pytest.fixture(scope="module")
def page(comparison):
    return render(analysis.load(comparison), networks={"twice": NET})


Z = "zhao2025"


def effect_by_hand(crashes):
    told, z = {}, Z
    base, aeb = ((crashes["of"] == name) for name in ("none", z))
    without, with_ = base.sum(), aeb.sum()
    told |= {f"{z}/crashes/without": without, f"{z}/crashes/net": without - with_, f"{z}/crashes/pairs": 20}
    told |= {f"{z}/crashes/percent": 100 * (1 - with_ / without), f"{z}/crashes/per_run": (without - with_) / 20}
    risk = crashes[["striker_serious_risk", "struck_serious_risk"]].sum(axis=1)
    death = crashes[["striker_death_risk", "struck_death_risk"]].sum(axis=1)
    for name, value in (
        ("crashes", pd.Series(1.0, crashes.index)), ("primary crashes", 1.0 - crashes["secondary"]),
        ("expected seriously injured", risk), ("expected deaths", death),
    ):  # fmt: skip
        b, a = value[base].sum(), value[aeb].sum()
        told |= {f"{z}/effect/{name}/baseline": b / 20, f"{z}/effect/{name}/with_aeb": a / 20}
        told |= {f"{z}/effect/{name}/avoided": (b - a) / 20}
        told |= {f"{z}/effect/{name}/percent": 100 * (1 - a / b) if b else np.nan}

    return told


def pairs_by_hand(crashes):
    told, z = {}, Z
    base, aeb = ((crashes["of"] == name) for name in ("none", z))
    risk = crashes[["striker_serious_risk", "struck_serious_risk"]].sum(axis=1)
    two = crashes.assign(who=crashes["run_id"].str.split("-").str[-1] + crashes["striker"] + crashes["struck"])
    without = base.sum()
    there = two[aeb].set_index("who")["impact_speed_mps"]
    both = two[base].assign(after=two["who"].map(there))
    change = both["after"] - both["impact_speed_mps"]
    injured = two.assign(risk=risk)[aeb].set_index("who")["risk"]
    safer = both["who"].map(injured) - risk[base]
    outcome = np.where(change.abs() < 1 / 3.6, "unchanged", np.where(safer < 0, "mitigated", "worsened"))
    outcome = pd.Series(np.where(both["after"].isna(), "avoided", outcome))
    new = ~two[aeb]["who"].isin(two[base]["who"])
    for name in ("avoided", "mitigated", "unchanged", "worsened", "new"):
        n = (outcome == name).sum() if name != "new" else new.sum()
        told |= {
            f"{z}/pairs/{name}/count": n,
            f"{z}/pairs/{name}/primary": n,
            f"{z}/pairs/{name}/percent": 100 * n / without,
        }
    # Every car that has an AEB acts on the only one ahead of it.
    told |= {f"{z}/pairs/avoided/intervened": (outcome == "avoided").sum(), f"{z}/pairs/avoided/diverged": 0}

    return told


def verdicts_by_hand(crashes, acts, km):
    told, z, aeb = {}, Z, crashes["of"] == Z
    known = acts["verdict"] != "unknown"
    for name in VERDICTS:
        n = (acts["verdict"] == name).sum()
        told |= {f"{z}/verdict/{name}/count": n}
        if name != "unknown":
            told |= {f"{z}/verdict/{name}/share": 100 * n / known.sum(), f"{z}/verdict/{name}/rate": n / km * 1000}
        for phase in acts["phase"].unique():
            seen = ((acts["phase"] == phase) & (acts["verdict"] == name)).sum()
            told |= {f"{z}/verdict/lead/{phase}/{name}": seen}
        if name in {"avoided", "unneeded"}:
            told |= {f"{z}/card/{name}/count": n, f"{z}/card/{name}/share": 100 * n / known.sum()}
    for reason, n in acts.loc[~known, "verdict_reason"].value_counts().items():
        told |= {f"{z}/unknown/{reason}": n}
    useful = acts["verdict"].isin(["avoided", "mitigated"]).sum()
    early, right = (acts["verdict"] == "precautionary").sum(), (acts["verdict"] == "avoided").sum()
    struck = (aeb & crashes["striker_equipped"]).sum()
    hard = (acts["with_follower_decel_mps2"] > 0.5 * 9.81) & ~(acts["without_follower_decel_mps2"] > 0.5 * 9.81)
    told |= {f"{z}/verdict/none/count": 0, f"{z}/quality/precision": 100 * useful / known.sum()}
    told |= {f"{z}/quality/precautionary": 100 * (useful + early) / known.sum()}
    told |= {f"{z}/quality/recall": 100 * right / (right + struck), f"{z}/quality/hard": 100 * hard[known].mean()}

    return told


def traffic_by_hand(traffic, avoided):
    told, z = {}, Z
    sums = traffic.groupby("of")[
        ["arrived", "distance_m", "time_s", "delay_s", "stops", "standing_s", "waiting_s", "blocked_s"]
    ].sum()
    hours = 20 * 7 / 3600
    lost = sums["delay_s"] + sums["waiting_s"]
    for name, value in {
        "flow": sums["arrived"] / hours, "largest flow in 5 min": sums["arrived"] * np.nan,
        "flow per lane out of queues": sums["arrived"] * np.nan, "travel time": sums["arrived"] * np.nan,
        "speed": 3.6 * sums["distance_m"] / sums["time_s"],
        "delay on the road": 1000 * sums["delay_s"] / sums["distance_m"],
        "stops": 1000 * sums["stops"] / sums["distance_m"], "standing": sums["standing_s"] / 3600 / 20,
        "delay": lost / 3600 / 20, "waiting to enter": sums["waiting_s"] / 3600 / 20,
        "behind wrecks": sums["blocked_s"] / 3600 / 20,
    }.items():  # fmt: skip
        told |= {f"{z}/traffic/{name}/baseline": value["none"], f"{z}/traffic/{name}/with_aeb": value[z]}
        told |= {f"{z}/traffic/{name}/change": value[z] - value["none"]}
        if name in {"flow", "delay on the road"}:
            told |= {f"{z}/card/{name}": value[z] - value["none"]}
    told |= {f"{z}/traffic/extra delay per avoided crash/{side}": np.nan for side in ("baseline", "with_aeb")}
    extra = (lost[z] - lost["none"]) / 3600
    told |= {f"{z}/traffic/extra delay per avoided crash/change": extra / avoided}

    return told


def events_by_hand(crashes, acts, exposure, km):
    told, z = {}, Z
    for name in ("none", z):
        some, driven = crashes[crashes["of"] == name], exposure.loc[exposure["of"] == name, "distance_m"].sum() / 1000
        told |= {f"{name}/crashes/rear_end": len(some), f"{name}/crashes/total": len(some)}
        told |= {f"{name}/crashes/secondary": some["secondary"].sum(), f"{name}/rate/crashes": len(some)}
        told |= {
            f"{name}/rate": len(some) / driven * 1e6,
            f"{name}/impact_speed": 3.6 * some["impact_speed_mps"].median(),
        }
    for phase in ("warn", "partial_brake", "full_brake"):
        some = acts[acts["phase"] == phase]
        told |= {f"{z}/{phase}/count": len(some), f"{z}/{phase}/rate": len(some) / km * 1000}
        if phase != "warn":
            ttc = some["trigger_ttc_s"].replace(np.inf, np.nan)
            told |= {
                f"{z}/{phase}/ttc": ttc.median(),
                f"{z}/{phase}/reduction": 3.6 * some["speed_reduction_mps"].median(),
            }
    return told


def by_hand(folder):
    """Every number that the report shows, by key, from the Parquet files alone."""
    runs, crashes, acts, exposure, traffic = (
        pd.read_parquet(folder / name) for name in ("runs", "crashes", "interventions", "exposure", "traffic")
    )
    system = runs.set_index("run_id")["strategy"]
    crashes, acts, exposure, traffic = (
        t.assign(of=t["run_id"].map(system)) for t in (crashes, acts, exposure, traffic)
    )
    km = exposure.loc[exposure["equipped"], "distance_m"].sum() / 1000
    told = effect_by_hand(crashes)
    told |= pairs_by_hand(crashes) | verdicts_by_hand(crashes, acts, km)
    told |= traffic_by_hand(traffic, told[f"{Z}/crashes/net"]) | events_by_hand(crashes, acts, exposure, km)
    for row in runs.to_dict("records"):
        told |= {f"run/{row['run_id']}/span": row["end_s"] - row["begin_s"]}
        told |= {f"run/{row['run_id']}/{c}": row[c] for c in ("vehicles", "equipped", "crashes", "override_violations")}
    return told


def test_every_number_of_a_20_seed_comparison_is_that_of_pandas(comparison, page):
    shown, expected = Page(page), by_hand(comparison)
    needed = {"zhao2025/crashes/seeds_needed"}  # has tests of its own
    assert set(shown.numbers) - needed == set(expected)
    for key, value in expected.items():
        assert shown.numbers[key] == pytest.approx(value, nan_ok=True, abs=1e-9), key
    assert 5 < expected["zhao2025/crashes/net"] < expected["zhao2025/crashes/without"], "there is something to show"


def test_the_intervals_of_a_20_seed_comparison_are_by_seed(comparison, page):
    shown, data = Page(page), analysis.load(comparison)
    seed = data.runs.set_index("run_id")["seed"]
    crashes, acts = data.crashes, data.interventions
    system = crashes["run_id"].map(data.runs.set_index("run_id")["strategy"])
    none, aeb = (
        crashes[system == name]["run_id"].map(seed).value_counts().reindex(SEEDS, fill_value=0)
        for name in ("none", "zhao2025")
    )
    for percent, key in ((False, "per_run"), (True, "percent")):
        found = analysis.paired_interval(none, aeb, percent=percent)
        assert shown.bounds[f"zhao2025/crashes/{key}"] == pytest.approx((-found.high, -found.low))
        assert shown.n[f"zhao2025/crashes/{key}"] == 20
    right = (acts["verdict"] == "avoided").groupby(acts["run_id"].map(seed)).agg(["sum", "size"])
    found = analysis.share_by_seed(right["sum"], right["size"])
    assert shown.bounds["zhao2025/card/avoided/share"] == pytest.approx((found.low, found.high))
    n, km = none.sum(), data.exposure[~data.exposure["run_id"].str.contains("zhao")]["distance_m"].sum() / 1e9
    exact = chi2.ppf(0.025, 2 * n) / 2 / km, chi2.ppf(0.975, 2 * n + 2) / 2 / km
    assert shown.bounds["none/rate"] == pytest.approx(exact)


def test_all_that_issue_and_reader_ask_for_is_there(page):
    shown = Page(page)
    assert [f["h3"] for f in shown.figures] == [
        "Crashes by seed: zhao2025", "Verdicts: zhao2025", "Throughput over time", "Mean speed over time",
        "Crashes by kind", "Impact speeds", "Time to collision at the trigger", "Speed taken off", "twice, none",
        "twice, zhao2025",
    ]  # fmt: skip
    text = "".join(shown.text)
    for heading in ("The answer", "Crash by crash", "Definitions", "How to repeat it", "Where it happened"):
        assert heading in text
    assert "aeb-sumo run twice --strategy zhao2025 --sensing ideal --penetration 0.5 --duration 7" in text
    assert "--verdicts all --interval 2" in text


def command(*arguments):
    return report.main([str(a) for a in arguments], standalone_mode=False)


def test_the_command_writes_one_file_and_the_same_again(comparison, tmp_path, capsys):
    assert command(comparison, "--out", tmp_path / "a.html", "--title", "Brakes & <more>") == 0
    assert capsys.readouterr().out.strip() == str(tmp_path / "a.html")
    moved = tmp_path / "elsewhere"
    shutil.copytree(comparison, moved)
    words = [sys.executable, "-m", "aeb_sumo", "report", str(moved), "--title", "Brakes & <more>"]
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
    assert (moved / "report.html").read_bytes() == (tmp_path / "a.html").read_bytes()
    assert "<title>Brakes &amp; &lt;more&gt;</title>" in (tmp_path / "a.html").read_text()
    # This scenario has no name that leads to a network.
    assert "The network of twice is not where it was" in (tmp_path / "a.html").read_text()


def test_bad_input_is_one_clear_line(comparison, tmp_path):
    (tmp_path / "empty").mkdir()
    other = tmp_path / "other"
    (other / "runs").mkdir(parents=True)
    pd.DataFrame({"run_id": ["a"]}).to_parquet(other / "runs" / "a.parquet")
    for arguments, said in (
        ([tmp_path / "missing"], "no folder"),
        ([tmp_path / "empty"], "no results in"),
        ([other], "another schema"),
        ([comparison, "--out", tmp_path / "no" / "a.html"], "existing folder"),
        ([comparison, "--out", tmp_path], "existing folder"),
    ):
        with pytest.raises(InputError, match=said) as error:
            command(*arguments)
        assert "\n" not in str(error.value)


def test_bad_input_ends_with_status_2(tmp_path):
    words = [sys.executable, "-m", "aeb_sumo", "report", str(tmp_path / "missing")]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)


@pytest.mark.parametrize("name", ["highway", "221", "w0"])
def test_packaged_scenarios_and_configurations_lead_to_their_networks(name, tmp_path):
    (path,) = _networks([name]).values()
    assert path.name == {"221": "w0.net.xml"}.get(name, f"{name}.net.xml")
    assert scenarios.load(name).options[1] == str(path)
    config = tmp_path / "my.sumocfg"
    config.write_text(f'<configuration><input><net-file value="{path.name}"/></input></configuration>')
    assert _networks([str(config)]) == {}
    shutil.copy(path, tmp_path)
    assert _networks([str(config)]) == {str(config): tmp_path / path.name}


CHROMIUM = shutil.which("chromium")
PROBE = """<!doctype html><body>
<iframe id="f" src="report.html" style="width:WIDTHpx;height:900px;border:0"></iframe>
<script>
document.getElementById("f").addEventListener("load", (event) => {
  const page = event.target.contentDocument, root = page.documentElement;
  const drawings = [...page.querySelectorAll("figure svg")].map((svg) => svg.getBoundingClientRect());
  const letters = [...page.querySelectorAll("figure svg text")].map((text) => text.getBoundingClientRect().height);
  document.title = JSON.stringify({
    width: root.clientWidth, needed: root.scrollWidth, figures: page.querySelectorAll("figure").length,
    drawn: drawings.filter((box) => box.width > 200 && box.height > 60).length, smallest: Math.min(...letters),
  });
});
</script></body>"""


def browse(*arguments, folder: Path):
    words = [
        CHROMIUM,
        "--headless=new",
        "--no-sandbox",
        "--disable-gpu",
        "--hide-scrollbars",
        "--allow-file-access-from-files",
    ]
    words += [f"--user-data-dir={folder / 'profile'}", "--enable-logging=stderr", "--v=0", "--virtual-time-budget=3000"]
    return subprocess.run([*words, *arguments], capture_output=True, text=True, check=True, timeout=60)


@pytest.mark.skipif(CHROMIUM is None, reason="needs Debian's chromium")
@pytest.mark.parametrize("width", [400, 1400])
def test_a_browser_shows_every_figure_without_an_error_or_a_scroll_bar(page, tmp_path, width):
    (tmp_path / "report.html").write_text(page, encoding="utf-8")
    (tmp_path / "probe.html").write_text(PROBE.replace("WIDTH", str(width)), encoding="utf-8")
    done = browse("--window-size=1500,1000", "--dump-dom", f"file://{tmp_path}/probe.html", folder=tmp_path)
    assert "CONSOLE" not in done.stderr, done.stderr
    found = re.search(r"<title>(.*?)</title>", done.stdout)
    assert found, done.stdout[:500]
    seen = json.loads(found[1].replace("&quot;", '"'))
    assert seen["width"] == width
    assert seen["needed"] <= width
    assert seen["figures"] == seen["drawn"] == page.count("<figure") == 10
    assert seen["smallest"] >= 9.5, "pixels of the smallest letters in a figure"


@pytest.mark.skipif(CHROMIUM is None, reason="needs Debian's chromium")
def test_the_browser_test_would_see_an_error(page, tmp_path):
    broken = page.replace("</body>", "<script>nothing.here()</script></body>")
    (tmp_path / "report.html").write_text(broken, encoding="utf-8")
    (tmp_path / "probe.html").write_text(PROBE.replace("WIDTH", "400"), encoding="utf-8")
    assert "CONSOLE" in browse("--dump-dom", f"file://{tmp_path}/probe.html", folder=tmp_path).stderr
