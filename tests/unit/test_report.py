"""The report from tables made by hand: every number against pandas, and all that can be missing."""

import gzip
import re
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.stats import binom, chi2

import analysis
import sumo_nets
from aeb_sumo.results import Results
from analysis.report import render
from analysis.report.drawing import SERIES, canvas, legend
from analysis.report.drawing import VERDICTS as VERDICT_COLOURS
from analysis.report.intervals import median, per_1000_km, share
from analysis.report.network import lanes
from analysis.report.parts import Quantity, number
from tests.pages import Page

VERDICTS = ("avoided", "unneeded", "unneeded", "precautionary", "unknown")


def run(strategy, seed, **changes):
    name = f"highway-{strategy}-p1-s{seed}"
    row = {
        "run_id": name,
        "scenario": "highway",
        "strategy": strategy,
        "sensing": "ideal",
        "parameters": "",
        "seed": seed,
    }
    row |= {"penetration": 0.0 if strategy == "none" else 1.0, "drivers": "highway", "step_length_s": 0.1, "mu": 0.85}
    row |= {"begin_s": 0.0, "end_s": 240.0, "demand": 1.0, "blockage_s": 60.0, "outcome": "completed", "reason": ""}
    row |= {"weather": "", "vehicles": 80, "equipped": 0 if strategy == "none" else 70, "crashes": 0}
    row |= {
        "override_commands": 10,
        "override_violations": 0,
        "aeb_sumo_version": "0.1.0",
        "sumo_version": "SUMO 1.28.0",
    }
    return row | changes


def crash(run_id, k, **changes):
    row = {
        "run_id": run_id,
        "crash_id": k,
        "time_s": 50.0 + k,
        "kind": "rear_end",
        "striker": f"a{k}",
        "struck": f"b{k}",
    }
    row |= {"x_m": 900.0 + 10 * k, "y_m": -3.2, "impact_speed_mps": 4.0 + k, "secondary": k > 2}
    return row | {"striker_serious_risk": None, "struck_serious_risk": 0.01 * (k + 1)} | changes


def intervention(run_id, k, **changes):
    row = {"run_id": run_id, "intervention_id": k, "vehicle": f"a{k}", "target": f"b{k}", "strategy": "zhao2025"}
    row |= {
        "phase": ("warn", "partial_brake", "full_brake")[k % 3],
        "target_kind": "lead",
        "begin_s": 45.0,
        "end_s": 48.0,
    }
    row |= {
        "trigger_ttc_s": 1.0 + 0.3 * k if k % 3 else None,
        "speed_reduction_mps": 2.0 * k,
        "x_m": 800.0,
        "y_m": -3.2,
    }
    return row | {"verdict": VERDICTS[k % 5], "verdict_reason": "it died" if k % 5 == 4 else ""} | changes


def tables(crashes, interventions, **changes):
    """Tables from numbers of crashes and interventions by (strategy, seed)."""
    rows = {name: [] for name in ("runs", "crashes", "interventions", "exposure", "traffic")}
    for (strategy, seed), count in crashes.items():
        one = run(strategy, seed, crashes=count, **changes)
        rows["runs"].append(one)
        name = one["run_id"]
        rows["crashes"] += [crash(name, k) for k in range(count)]
        rows["interventions"] += [intervention(name, k) for k in range(interventions.get((strategy, seed), 0))]
        system = strategy.replace("none", "")
        road = {"run_id": name, "vclass": "passenger"}
        rows["exposure"].append(road | {"equipped": bool(system), "strategy": system, "distance_m": 5e5 + 1e4 * seed})
        for k in range(4):
            part = {"begin_s": 60.0 * k, "end_s": 60.0 * (k + 1), "arrived": 10 + seed + k, "removed": 0, "pending": 0}
            part |= {
                "waiting_s": 0.0,
                "distance_m": 1e5 + 100 * seed,
                "time_s": 4e3 + 10 * seed + bool(system),
                "stops": 3,
            }
            part |= {"delay_s": 200.0 + seed * (1 + bool(system)), "standing_s": 9.0, "blocked_s": 0.0, "discharged": 0}
            rows["traffic"].append(road | part | {"travel_time_s": 900.0, "headway_s": 0.0, "departed": 12})
    return rows


def dataset(*given, **changes):
    return analysis.Dataset.of(Results.of(tables(*given, **changes)))


CRASHES = {("none", 1): 5, ("none", 2): 3, ("none", 3): 8, ("zhao2025", 1): 1, ("zhao2025", 2): 0, ("zhao2025", 3): 4}
ACTIONS = {("zhao2025", 1): 10, ("zhao2025", 2): 7, ("zhao2025", 3): 6}
NET = {"highway": sumo_nets.folder("highway") / "highway.net.xml"}


@pytest.fixture(scope="module")
def page():
    return Page(render(dataset(CRASHES, ACTIONS), networks=NET))


def sound(text):
    """What every page must be."""
    page = Page(text)
    assert len(page.ids) == len(set(page.ids)), [i for i in page.ids if page.ids.count(i) > 1]
    assert all(link.startswith("#") or link == "data:," for link in page.links), page.links
    assert all(link[1:] in page.ids for link in page.links if link.startswith("#"))
    assert "http" not in re.sub(r'xmlns(:\w+)?="[^"]*"', "", text)
    assert not re.search(r"url\((?!#)|@import|<script", text)
    assert all(d["role"] == "img" and len(str(d["aria-label"])) > 20 for d in page.drawings)
    assert len(page.figures) == len(page.drawings)
    assert all(f["h3"] and f["figcaption"] for f in page.figures)
    assert "nan" not in " ".join(page.text).split()
    return page


def test_the_page_is_sound_and_the_same_each_time():
    data = dataset(CRASHES, ACTIONS)
    text = render(data, networks=NET)
    sound(text)
    assert text == render(data, networks=NET)
    assert "/work" not in text
    assert str(NET["highway"]) not in text


def test_every_axis_has_its_unit(page):
    for figure in page.figures:
        drawn = figure.get("drawn", "")
        assert re.search(r"\[[^\]]+\]|per hour|crashes in the run|crashes per run|no ", drawn), figure["h3"]


def test_the_answer_is_that_of_pandas(page):
    assert page.numbers["zhao2025/crashes/without"] == 5 + 3 + 8
    assert page.numbers["zhao2025/crashes/net"] == 16 - 5
    assert page.numbers["zhao2025/crashes/pairs"] == 3
    assert page.numbers["zhao2025/crashes/percent"] == pytest.approx(100 * 11 / 16)
    assert page.numbers["zhao2025/crashes/per_run"] == pytest.approx(11 / 3)
    found = analysis.paired_interval([5, 3, 8], [1, 0, 4])
    assert page.bounds["zhao2025/crashes/per_run"] == pytest.approx((-found.high, -found.low))
    assert page.n["zhao2025/crashes/per_run"] == 3
    primary = (
        page.numbers["zhao2025/effect/primary crashes/baseline"],
        page.numbers["zhao2025/effect/primary crashes/with_aeb"],
    )
    assert primary == (3, pytest.approx((1 + 0 + 3) / 3))
    serious = 0.01 * (sum(range(1, 6)) + sum(range(1, 4)) + sum(range(1, 9))) / 3
    assert page.numbers["zhao2025/effect/expected seriously injured/baseline"] == pytest.approx(serious)


def test_pairs_are_those_of_the_same_two_vehicles(page):
    # Crash k is always that of ak and bk, as hard in both worlds.
    assert page.numbers["zhao2025/pairs/avoided/count"] == 4 + 3 + 4
    assert page.numbers["zhao2025/pairs/unchanged/count"] == 5
    assert page.numbers["zhao2025/pairs/new/count"] == 0
    assert page.numbers["zhao2025/pairs/avoided/percent"] == pytest.approx(100 * 11 / 16)
    # The AEB of ak acts on bk 5 s and more before, in the runs with so many interventions.
    acted = sum(max(0, min(n, ACTIONS["zhao2025", s]) - CRASHES["zhao2025", s]) for s, n in ((1, 5), (2, 3), (3, 8)))
    assert page.numbers["zhao2025/pairs/avoided/intervened"] == acted
    assert page.numbers["zhao2025/pairs/avoided/diverged"] == 11 - acted


def test_verdicts_are_counted_and_shared_by_seed(page):
    seen = pd.Series([VERDICTS[k % 5] for n in ACTIONS.values() for k in range(n)]).value_counts()
    known = seen.drop("unknown").sum()
    for verdict in ("avoided", "unneeded", "precautionary", "unknown", "induced"):
        assert page.numbers[f"zhao2025/verdict/{verdict}/count"] == seen.get(verdict, 0)
    assert page.numbers["zhao2025/verdict/unneeded/share"] == pytest.approx(100 * seen["unneeded"] / known)
    assert page.numbers["zhao2025/card/avoided/share"] == pytest.approx(100 * seen["avoided"] / known)
    assert page.n["zhao2025/verdict/unneeded/share"] == known
    km = sum(5e5 + 1e4 * s for s in (1, 2, 3)) / 1000
    rate, n = seen["unneeded"] / km * 1000, seen["unneeded"]
    exact = chi2.ppf(0.025, 2 * n) / 2 / km * 1000, chi2.ppf(0.975, 2 * n + 2) / 2 / km * 1000
    assert page.numbers["zhao2025/verdict/unneeded/rate"] == pytest.approx(rate)
    assert page.bounds["zhao2025/verdict/unneeded/rate"] == pytest.approx(exact)
    assert page.numbers["zhao2025/unknown/it died"] == seen["unknown"]


def test_crashes_and_interventions_are_those_of_pandas(page):
    assert page.numbers["none/crashes/rear_end"] == 16
    assert page.numbers["none/crashes/secondary"] == 2 + 0 + 5
    km = sum(5e5 + 1e4 * s for s in (1, 2, 3)) / 1000
    assert page.numbers["none/rate"] == pytest.approx(16 / km * 1e6)
    speeds = pd.Series([4.0 + k for n in (5, 3, 8) for k in range(n)])
    assert page.numbers["none/impact_speed"] == pytest.approx(3.6 * speeds.median())
    ttc = pd.Series([1 + 0.3 * k for n in ACTIONS.values() for k in range(n) if k % 3 == 1])
    assert page.numbers["zhao2025/partial_brake/count"] == len(ttc)
    assert page.numbers["zhao2025/partial_brake/ttc"] == pytest.approx(ttc.median())


def test_traffic_is_that_of_pandas(page):
    before = sum(4 * (200 + s) for s in (1, 2, 3)) / (sum(4 * (1e5 + 100 * s) for s in (1, 2, 3)) / 1000)
    after = sum(4 * (200 + 2 * s) for s in (1, 2, 3)) / (sum(4 * (1e5 + 100 * s) for s in (1, 2, 3)) / 1000)
    assert page.numbers["zhao2025/traffic/delay on the road/baseline"] == pytest.approx(before)
    assert page.numbers["zhao2025/traffic/delay on the road/change"] == pytest.approx(after - before)
    assert page.numbers["zhao2025/card/delay on the road"] == pytest.approx(after - before)


def test_the_repeated_commands_name_every_run(page):
    text = " ".join(page.text)
    assert "for seed in 1 2 3; do" in text
    assert "aeb-sumo run highway --strategy none --duration 240 --step-length 0.1 --blockage 60 --seed" in text
    assert "aeb-sumo run highway --strategy zhao2025 --sensing ideal --penetration 1 --duration 240" in text
    assert "aeb-sumo 0.1.0, SUMO 1.28.0" in text


def test_runs_with_ceilings_are_repeated_with_them_and_others_are_not():
    rows = tables({("none", 1): 2, ("zhao2025", 1): 1}, ACTIONS)
    baseline = rows["runs"][0]["run_id"]
    rows["ceilings"] = [{"run_id": baseline, "crash_id": 0, "ceiling": "perfect", "outcome": "avoided"}]
    shown = Page(render(analysis.Dataset.of(Results.of(rows)), networks=NET))
    lines = [line for text in shown.text for line in text.splitlines() if line.startswith("aeb-sumo run")]
    assert [("--strategy none" in line, "--ceilings" in line) for line in lines] == [(True, True), (False, False)]


def test_two_names_that_do_not_fit_beside_each_other_stand_below_each_other():
    for names, columns in ((["none", "zhao2025"], 2), (["zhao2025, scenario highway (n = 293)", "x" * 30], 1)):
        with canvas(2.0) as (figure, axes):
            for name in names:
                axes.plot([0, 1], label=name)
            legend(figure, axes)
            assert figure.legends[0]._ncols == columns


def test_the_page_says_when_the_world_is_forked(page):
    text = " ".join(" ".join(page.text).split())
    assert "because the brake bit or the driver heeded the warning" in text
    assert "reached the driver" not in text


@pytest.mark.parametrize(
    ("crashes", "interventions", "said"),
    [
        ({("none", 1): 3, ("none", 2): 0}, {}, "3 crashes without AEB"),
        ({("none", 1): 0}, {}, "0 crashes without AEB"),
        ({("zhao2025", 1): 2}, ACTIONS, "2 crashes with AEB; no baseline to compare with"),
        ({("none", 1): 0, ("zhao2025", 1): 0}, {}, "No crash, neither without AEB nor with it"),
        ({("none", 1): 2, ("zhao2025", 1): 0}, {}, "2 of 2 crashes avoided, net"),
        ({("none", 1): 1, ("zhao2025", 1): 3}, ACTIONS, "2 crashes more than the 1 without AEB"),
        ({("none", 1): 1, ("zhao2025", 1): 1, ("yan2025", 1): 0}, ACTIONS, "One seed"),
        ({("none", 1): 1, ("zhao2025", 2): 1}, ACTIONS, "no completed baseline run of the same seed"),
        ({("none", 1): 1, ("none", 2): 1, ("zhao2025", 1): 1, ("zhao2025", 3): 1}, ACTIONS, "1 of its runs"),
    ],
)
def test_whatever_is_missing_is_said(crashes, interventions, said):
    text = render(dataset(crashes, interventions), networks=NET)
    page = sound(text)
    assert said in re.sub(r"\s+", " ", "".join(page.text)).replace(" ( ", " (")


def test_an_interrupted_and_a_failed_run_are_not_compared():
    rows = tables(CRASHES, ACTIONS)
    rows["runs"][0] |= {"outcome": "interrupted", "end_s": 120.0}
    rows["runs"][4] |= {"outcome": "failed", "reason": "Edge 'x' is gone <really>", "end_s": 60.0}
    page = sound(render(analysis.Dataset.of(Results.of(rows)), networks=NET))
    text = "".join(page.text)
    assert "1 of 6 runs was interrupted by the user" in text
    assert "given up by SUMO (Edge 'x' is gone <really>)" in text
    assert page.numbers["zhao2025/crashes/pairs"] == 1  # seed 3
    assert page.numbers["zhao2025/crashes/without"] == 8


def test_runs_that_never_got_to_traffic_have_a_report():
    data = dataset({("none", 1): 0, ("zhao2025", 1): 0}, {}, outcome="failed", reason="no", end_s=0.0)
    data = replace(data, **{f.name: getattr(data, f.name).iloc[:0] for f in fields(data) if f.name != "runs"})
    page = sound(render(data))
    assert "There is no traffic to show" in " ".join(str(d["aria-label"]) for d in page.drawings)


def test_without_verdicts_the_page_says_that_they_are_unknown():
    rows = tables(CRASHES, ACTIONS)
    for one in rows["interventions"]:
        one["verdict"] = ""
    page = sound(render(analysis.Dataset.of(Results.of(rows))))
    text = "".join(page.text)
    assert "none was asked for when these runs were made" in text
    assert not any("/verdict/" in key for key in page.numbers)


def test_several_systems_stand_side_by_side():
    data = dataset(CRASHES | {("yan2025", s): s for s in (1, 2, 3)}, ACTIONS)
    page = sound(render(data, networks=NET))
    assert page.numbers["yan2025/crashes/net"] == 16 - 6
    assert page.numbers["zhao2025/crashes/net"] == 11


def test_names_from_outside_are_text_and_no_markup():
    data = dataset(CRASHES, ACTIONS, scenario="my/<b>&city.sumocfg", drivers='"quoted"')
    text = render(data, title="<i>A & B</i>")
    sound(text)
    assert "<b>" not in text
    assert "<i>" not in text
    assert "far more driver errors" not in text, "that is said of the scenarios of the package alone"


def test_where_the_network_is_gone_the_points_stand_alone():
    text = "".join(Page(render(dataset(CRASHES, ACTIONS), networks={})).text)
    assert "The network of highway is not where it was" in text
    text = "".join(Page(render(dataset(CRASHES, ACTIONS), networks=NET)).text)
    assert "is not where it was" not in text


def test_lanes_are_read_from_a_plain_and_a_packed_net(tmp_path):
    plain = lanes(NET["highway"])
    packed = tmp_path / "net.xml.gz"
    packed.write_bytes(gzip.compress(NET["highway"].read_bytes()))
    again = lanes(packed)
    assert plain is not None
    assert again is not None
    assert len(plain) == NET["highway"].read_text().count("<lane ")
    assert all((a == b).all() for a, b in zip(plain, again, strict=True))
    broken = tmp_path / "broken.net.xml"
    broken.write_text("<net><edge><lane shape='1,2 3")
    assert lanes(broken) is None
    assert lanes(tmp_path / "missing") is None


@pytest.mark.parametrize(
    ("value", "decimals", "signed", "text"),
    [
        (1234567.0, 0, False, "1 234 567"), (-0.5, 1, True, "−0.5"), (0.5, 1, True, "+0.5"), (-0.001, 1, True, "0.0"),
        (np.nan, 1, True, "–"), (-np.inf, 0, True, "−∞"),
    ],
)  # fmt: skip
def test_numbers_for_people(value, decimals, signed, text):
    assert number(value, decimals, signed=signed).replace("\u202f", " ") == text


def test_an_interval_has_the_digits_of_its_number():
    shown = Quantity(key="", value=0.0123, low=0.0011, high=0.031, unit="h", n=3, of="seeds")
    assert (shown.text, shown.interval, shown.rests_on) == ("0.012 h", "95 %: 0.001 to 0.031", "n = 3 seeds")
    assert Quantity(key="", value=50.0, n=1, of="crashes").small == "n = 1 crash"


@pytest.mark.parametrize("n", [1, 5, 6, 9, 20, 101])
def test_the_median_lies_between_order_statistics_that_cover_95_percent(n):
    found = median("", pd.Series(np.arange(n, dtype=float)), "values", "")
    assert found.value == (n - 1) / 2
    if n < 6:
        assert np.isnan(found.low)
        return
    low, high = int(found.low), int(found.high)
    assert high == n - 1 - low
    assert 1 - 2 * binom.cdf(low, n, 0.5) >= 0.95
    assert 1 - 2 * binom.cdf(low + 1, n, 0.5) < 0.95


def test_a_share_of_nothing_and_a_rate_over_nothing_are_unknown():
    assert np.isnan(share("", pd.Series([], dtype=bool), pd.Series([], dtype=float), "verdicts").value)
    assert np.isnan(per_1000_km("", 0, 0.0).value)
    assert per_1000_km("", 0, 0.0).interval == ""


def _luminance(colour):
    parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    linear = [p / 12.92 if p <= 0.03928 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


@pytest.mark.parametrize("mode", [0, 1], ids=["light", "dark"])
def test_colours_can_be_told_from_the_page(mode):
    css = (Path(analysis.__file__).parent / "report" / "report.css").read_text()
    colours = dict(re.findall(r"--([\w-]+): (#\w{6})", re.findall(r":root \{(.*?)\}", css, re.S)[mode]))
    drawn = {f"series-{k}" for k in range(len(SERIES))} | {f"verdict-{name}" for name in VERDICT_COLOURS}
    assert drawn <= set(colours)
    for names, least in (({"ink", "faint", "link"}, 4.5), (drawn, 3.0)):  # WCAG 2.1, text and graphics
        for name in names:
            bright, dark = sorted((_luminance(colours[name]), _luminance(colours["page"])), reverse=True)
            assert (bright + 0.05) / (dark + 0.05) >= least, name
