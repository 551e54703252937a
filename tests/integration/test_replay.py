import json
import re
import subprocess
import sys
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from aeb_sumo import scenarios
from aeb_sumo.errors import InputError
from aeb_sumo.replay import film, replay
from aeb_sumo.replay.event import find
from aeb_sumo.replay.page import page
from aeb_sumo.results import read, write
from aeb_sumo.simulate import run


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The track: without AEB, with one that avoids the crash, and with one that comes too late."""
    path = tmp_path_factory.mktemp("track")
    for strategy in ("none", "zhao2025", "staged"):
        write(run(scenarios.load("track"), strategy, seed=1, duration=12.0, verdicts="all"), path)
    return path


AVOIDED, LATE, BASELINE = (f"track-{name}-s1" for name in ("zhao2025-p1", "staged-p1", "none-p0"))


def data_of(html):
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', html, re.DOTALL)[1])


def of_run(folder, table, run_id):
    frame = read(folder).frame(table)
    return frame[frame["run_id"] == run_id].iloc[0]


def test_an_intervention_is_set_against_the_world_of_its_verdict(folder):
    row = of_run(folder, "interventions", AVOIDED)
    data = data_of(replay(folder, "intervention:0", run_id=AVOIDED))
    with_, without = data["worlds"]
    assert row["verdict"] == "avoided"
    assert with_["contacts"] == []
    (hit,) = without["contacts"]
    assert hit["speed"] == pytest.approx(row["without_impact_speed_mps"], abs=1e-4)
    assert {hit["striker"], hit["struck"]} == {row["vehicle"], row["target"]}
    # What is drawn is what the tables say of this world: its braking, and its speed when it began.
    begin = with_["t"].index(0.0)
    assert with_["speed"][begin] == pytest.approx(row["speed_mps"], abs=1e-3)
    assert max(v for v in with_["brake"] if v is not None) == pytest.approx(row["max_decel_mps2"], abs=1e-3)
    assert min(v for v in with_["gap"] if v is not None) == pytest.approx(row["with_min_gap_m"], abs=0.01)
    assert data["parting"] == pytest.approx(row["acted_s"] - row["begin_s"])


def test_until_the_worlds_part_they_are_one_and_then_they_are_not(folder):
    data = data_of(replay(folder, "intervention:0", run_id=AVOIDED))
    with_, without = data["worlds"]
    until = 1 + with_["t"].index(data["parting"])
    for curve in ("t", "gap", "speed", "decel", "other"):
        assert with_[curve][:until] == without[curve][:until]
        assert curve in ("t", "other") or with_[curve][until + 2] != without[curve][until + 2]
    assert with_["t"][0] == -2.0  # the run begins there; else it would be 5 s before
    assert with_["t"][-1] == 11.7  # six seconds after its end
    assert max(v or 0.0 for v in without["brake"]) == 0


def test_a_crash_despite_an_intervention_is_set_against_the_world_without_it(folder):
    row, intervention = of_run(folder, "crashes", LATE), of_run(folder, "interventions", LATE)
    html = replay(folder, "crash:0", run_id=LATE)
    data = data_of(html)
    (hit,), (harder,) = (world["contacts"] for world in data["worlds"])
    assert hit["t"] == 0.0
    assert hit["speed"] == pytest.approx(row["impact_speed_mps"], abs=1e-4)
    assert harder["speed"] == pytest.approx(intervention["without_impact_speed_mps"], abs=1e-4)
    assert harder["t"] < 0
    assert "mitigated" in html
    assert "Without the intervention" in html


def test_a_crash_of_the_baseline_is_set_against_the_world_with_the_other_group_s_aeb(folder, tmp_path):
    html = replay(folder, "crash:0", run_id=BASELINE)
    (hit,), other = (world["contacts"] for world in data_of(html)["worlds"])
    assert hit["speed"] == pytest.approx(of_run(folder, "crashes", BASELINE)["impact_speed_mps"], abs=1e-4)
    # Of the two groups the first in order is taken: the late one. Its crash is softer.
    assert "With staged in ego and lead" in html
    assert 0 < other[0]["speed"] < hit["speed"]
    alone = tmp_path / "alone"
    write(run(scenarios.load("track"), "none", duration=6.0), alone)
    assert "With zhao2025 in ego and lead" in (avoided := replay(alone, "crash:0"))
    assert data_of(avoided)["worlds"][1]["contacts"] == []


def test_the_numbers_of_both_worlds_are_those_of_the_verdict(folder):
    take = film(find(folder, "intervention:0", LATE))
    row = take.event.row
    assert take.verdict == row["verdict"] == "mitigated"
    for world, name in zip(take.worlds, ("with", "without"), strict=True):
        assert world.outcome.hardest.impact_speed == pytest.approx(row[f"{name}_impact_speed_mps"])
        assert world.outcome.hardest.delta_v == pytest.approx(row[f"{name}_delta_v_mps"])
        assert world.outcome.follower_decel == row[f"{name}_follower_decel_mps2"]


def test_the_road_is_under_the_wheels(folder):
    data = data_of(replay(folder, "crash:0", run_id=LATE))
    (x, y), lanes = (data["worlds"][0]["tracks"]["ego"][axis][0] for axis in "xy"), data["lanes"]
    assert lanes
    straight = [np.reshape(lane["p"], (-1, 2)) for lane in lanes]
    assert min(abs(line[0, 1] - y) for line in straight) < 0.1
    assert any(line[:, 0].min() <= x <= line[:, 0].max() for line in straight)


def test_the_same_input_makes_the_same_bytes(folder):
    assert replay(folder, "crash:0", run_id=LATE) == replay(folder, "crash:0", run_id=LATE)


def test_a_run_that_was_not_judged_is_replayed_from_the_beginning_of_the_intervention(tmp_path):
    write(run(scenarios.load("track"), "staged", seed=1, duration=6.0), tmp_path)
    take = film(find(tmp_path, "intervention:0"))
    assert take.parting == take.event.row["begin_s"]
    assert take.verdict == "mitigated"
    assert "mitigated" in page(take)


def test_an_intervention_that_the_end_of_the_run_cut_short_is_shown_to_its_end(tmp_path):
    write(run(scenarios.load("track"), "zhao2025", seed=1, duration=3.0), tmp_path)
    take = film(find(tmp_path, "intervention:0"))
    assert take.event.row["ended_by"] == "run_end"
    assert take.factual.film.times[-1] > 12
    assert take.verdict == "avoided"


def test_seconds_before_and_after_can_be_chosen(folder):
    times = data_of(replay(folder, "crash:0", run_id=LATE, before=3.5, after=9.0))["worlds"][0]["t"]
    # The worlds part before that, and some run-up is shown in any case.
    assert times[0] == pytest.approx(2.0 - 1.0 - 4.83, abs=0.1)
    assert times[-1] == pytest.approx(9.0, abs=0.11)
    with pytest.raises(InputError, match=r"seconds after the event must lie within 0\.\.120, not -1"):
        replay(folder, "crash:0", run_id=LATE, after=-1)


class Structure(HTMLParser):
    def __init__(self):
        super().__init__()
        self.found = []

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))


def test_the_page_needs_nothing_else_and_says_what_it_shows(folder):
    html = replay(folder, "intervention:0", run_id=AVOIDED)
    tags = Structure()
    tags.feed(html)
    assert not [a for _, attrs in tags.found for a in attrs if a in {"src", "href", "srcset"}]
    assert "default-src 'none'" in html
    assert re.findall(r"https?://[^\"'\s]+", html) == ["http://www.w3.org/2000/svg"]
    drawn = [attrs for tag, attrs in tags.found if attrs.get("role") == "img"]
    assert len(drawn) == 5
    assert all(attrs["aria-label"] for attrs in drawn)
    assert {"en"} == {attrs["lang"] for tag, attrs in tags.found if tag == "html"}
    for unit in ("[m]", "[km/h]", "[m/s²]"):
        assert unit in html
    assert "aeb-sumo run track --strategy zhao2025" in html


def test_no_name_can_break_out_of_the_page(folder):
    take, nasty = film(find(folder, "crash:0", BASELINE)), "</script><img src=x>&'\""
    world = take.factual.film
    world.cast[nasty] = world.cast.pop("ego")
    world.frames[:] = [replace(f, ids=tuple(nasty if i == "ego" else i for i in f.ids)) for f in world.frames]
    event = replace(take.event, row={**take.event.row, "striker": nasty})
    html = page(replace(take, event=event, other=None, reason="none asked for"))
    tags = Structure()
    tags.feed(html)
    assert "img" not in [tag for tag, _ in tags.found]
    assert data_of(html)["ego"] == nasty
    assert "There is no other world to compare with: none asked for." in html


def test_an_event_that_is_not_there_is_named(folder, tmp_path):
    for text, message in (
        ("crash", "cannot read the event 'crash'; write crash:ID"),
        ("brake:1", "cannot read the event 'brake:1'"),
        ("crash:-1", "cannot read the event"),
        ("crash:9", f"no crash:9 in .*: 0 in {AVOIDED}, 1 in {BASELINE}, 1 in {LATE}"),
        ("crash:0", f"crash:0 is in 2 runs; choose one with --run: {BASELINE}, {LATE}"),
    ):
        with pytest.raises(InputError, match=message):
            replay(folder, text)
    with pytest.raises(InputError, match=f"no run 'x' in .*; there are: {BASELINE}, "):
        replay(folder, "crash:0", run_id="x")
    with pytest.raises(InputError, match="no results in"):
        replay(tmp_path, "crash:0")


def test_a_run_that_comes_out_otherwise_is_refused_with_both_versions(folder):
    event = find(folder, "crash:0", BASELINE)
    moved = replace(event, row={**event.row, "time_s": event.row["time_s"] + 0.3})
    with pytest.raises(InputError, match=r"crash:0 of track-none-p0-s1 does not happen again .* SUMO 1\.28.*, now "):
        film(moved)
    other = replace(find(folder, "intervention:0", AVOIDED), run={**event.run, "mu": 0.3, "run_id": "track-mu0.3-none"})
    with pytest.raises(InputError, match=r"intervention:0 of .* does not happen again"):
        film(other)


@pytest.mark.slow
def test_at_an_intersection_every_verdict_is_that_of_its_replay(tmp_path):
    write(run(scenarios.load("w0"), "zhao2025", seed=1, duration=105.0, verdicts="all"), tmp_path)
    rows = read(tmp_path).interventions
    assert {"avoided", "unneeded"} <= set(rows["verdict"])
    for number in rows.groupby("verdict")["intervention_id"].first():
        take = film(find(tmp_path, f"intervention:{number}"))
        row, hardest = take.event.row, take.other.outcome.hardest
        assert take.verdict == row["verdict"]
        assert (hardest is not None) == row["without_crash"]
        assert hardest is None or hardest.impact_speed == row["without_impact_speed_mps"]
        for world, name in zip(take.worlds, ("with", "without"), strict=True):
            assert world.outcome.min_gap == row[f"{name}_min_gap_m"] or np.isnan(row[f"{name}_min_gap_m"])


def test_the_command_writes_one_file_and_bad_input_none(folder):
    def command(*words):
        line = [sys.executable, "-m", "aeb_sumo", "replay", str(folder), *words]
        return subprocess.run(line, capture_output=True, text=True, check=False)

    before = sorted(folder.rglob("*"))
    bad = command("crash:0")
    assert bad.returncode == 2
    assert bad.stderr.count("\n") == 1
    assert "choose one with --run" in bad.stderr
    assert sorted(folder.rglob("*")) == before
    good = command("crash:0", "--run", LATE)
    assert good.returncode == 0, good.stderr
    (made,) = set(folder.rglob("*")) - set(before)
    assert made == folder / f"replay-{LATE}-crash-0.html"
    assert made.read_text() == replay(folder, "crash:0", run_id=LATE)
    made.unlink()


def test_an_event_too_long_for_the_name_of_a_file_is_one_clear_line(folder):
    words = [sys.executable, "-m", "aeb_sumo", "replay", str(folder), "a" * 400]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert "cannot read the event" in done.stderr
