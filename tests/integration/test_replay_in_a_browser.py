"""The page as Chromium shows it; skipped where there is none."""

import html
import re
import shutil
import subprocess

import pytest

from aeb_sumo import scenarios
from aeb_sumo.replay import replay
from aeb_sumo.results import write
from aeb_sumo.simulate import run

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")

PROBE = """
<script>{
  const note = (name, value) => { document.body.dataset[name] = value; };
  const key = (k) => document.dispatchEvent(new KeyboardEvent("keydown", { key: k, bubbles: true }));
  const clock = () => document.getElementById("clock").textContent;
  const canvas = document.getElementById("view1"), c = canvas.getContext("2d");
  const colours = new Set();
  const pixels = c.getImageData(0, 0, canvas.width, canvas.height).data;
  for (let k = 0; k < pixels.length; k += 4) colours.add(pixels.slice(k, k + 3).join());
  note("colours", colours.size);
  note("now", document.getElementById("now0").textContent + " | " + document.getElementById("now1").textContent);
  note("curves", document.querySelectorAll(".chart path.line").length);
  note("start", clock());
  key("ArrowRight"); note("right", clock());
  key("Home"); note("home", clock());
  key("End"); note("end", clock());
  const slider = document.getElementById("time");
  slider.value = 1; slider.dispatchEvent(new Event("input")); note("slid", clock());
  note("range", slider.min + " " + slider.max);
  document.getElementById("play").click(); note("playing", document.getElementById("play").textContent);
  tick(before + 500); note("played", clock());  // what the browser does when it wants a picture half a second later
  note("wide", document.documentElement.scrollWidth);
}</script></body>"""


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("track")
    write(run(scenarios.load("track"), "staged", seed=1, duration=6.0, verdicts="all"), folder)
    return replay(folder, "crash:0")


def opened(path, tmp_path, fragment=""):
    """What Chromium makes of a page: its document, and what it says on the console."""
    words = [
        CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path / 'profile'}",
        "--enable-logging=stderr", "--virtual-time-budget=2000", "--window-size=1400,1000", "--dump-dom",
        path.as_uri() + fragment,
    ]  # fmt: skip
    done = subprocess.run(words, capture_output=True, text=True, timeout=120, check=True)
    return done.stdout, [line for line in done.stderr.splitlines() if "CONSOLE" in line]


def notes(document):
    body = re.search(r"<body([^>]*)>", document)[1]
    return {name: html.unescape(value) for name, value in re.findall(r'data-(\w+)="([^"]*)"', body)}


def test_it_draws_plays_and_listens_without_an_error(page, tmp_path):
    path = tmp_path / "page.html"
    path.write_text(page.replace("</body>", PROBE))
    document, console = opened(path, tmp_path, "#t=-0.5")
    assert console == []
    found = notes(document)
    assert int(found["colours"]) > 8  # ground, road, marks, cars, names
    assert found["curves"] == "8"  # gap, two speeds, deceleration; in both worlds
    factual, other = found["now"].replace("\xa0", " ").split(" | ")
    assert "AEB brakes" in factual
    assert "AEB" not in other
    assert "km/h" in other
    assert found["start"] == "t = −0.5 s"
    assert found["right"] == "t = −0.4 s"
    low, high = map(float, found["range"].split())
    assert found["home"] == f"t = −{-low:.1f} s"
    assert found["end"] == f"t = {high:.1f} s"
    assert found["slid"] == "t = 1.0 s"
    assert found["playing"] == "Pause"
    assert found["played"] == "t = 1.5 s"


@pytest.mark.parametrize("width", [400, 1400])
def test_nothing_sticks_out(page, tmp_path, width):
    path = tmp_path / "frame.html"
    inside = html.escape(page.replace("</body>", PROBE), quote=True)
    outer = "document.body.dataset.wide = frame.contentDocument.body.dataset.wide"
    path.write_text(
        f'<!doctype html><body><iframe id="frame" style="border:0;width:{width}px;height:900px" onload="{outer}" '
        f'srcdoc="{inside}"></iframe></body>'
    )
    document, console = opened(path, tmp_path)
    assert console == []
    assert int(notes(document)["wide"]) <= width
