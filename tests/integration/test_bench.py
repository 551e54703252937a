"""aeb-sumo bench: bare SUMO and equipped runs from the same world."""

import json
import math
import os
import signal
import subprocess
import sys
import time
from functools import partial

import libsumo
import pytest

from aeb_sumo import scenarios
from aeb_sumo.bench.copies import side_by_side
from aeb_sumo.bench.measure import warm
from aeb_sumo.bench.process import in_fresh_processes, link
from aeb_sumo.errors import InputError
from aeb_sumo.scenarios.options import start_options
from aeb_sumo.world.session import Session
from tests.helpers import command


def numbers(content: object) -> list[float]:
    if isinstance(content, dict | list):
        return [n for part in (content.values() if isinstance(content, dict) else content) for n in numbers(part)]
    return [content] if isinstance(content, int | float) else []


def test_a_small_bench_prints_a_table_and_writes_json(tmp_path):
    done = command("bench", "--vehicles", 20, "--steps", 20, "--repeat", 1, "--json", tmp_path / "bench.json")
    assert done.returncode == 0, done.stderr
    for word in ("ratio", "us per", "per core-hour", "memory", "zhao2025", "Python", "SUMO 1."):
        assert word in done.stdout
    content = json.loads((tmp_path / "bench.json").read_text())
    (line,) = content["lines"]
    assert all(math.isfinite(n) and n > 0 for n in numbers(line))
    assert line["vehicles_asked"] == 20
    for name in ("bare", "equipped"):
        side = line[name]
        assert 15 < side["vehicles_present"] < 25
        (measured,) = side["measured"]
        assert measured["steps"] == 20
        assert side["us_per_vehicle_step"]["median"] == pytest.approx(
            1e6 * measured["cpu_s"] / measured["vehicle_steps"]
        )
    assert line["equipped"]["peak_memory_mb"] > line["bare"]["peak_memory_mb"]
    assert {"cpu", "cores", "python", "sumo", "aeb_sumo"} <= {*content["machine"]}


def test_other_scenarios_are_measured_with_who_is_there(tmp_path):
    options = ("--scenario", "w0", "--from", 30, "--steps", 10, "--repeat", 2, "--strategy", "none", "--quiet")
    done = command("bench", *options, "--step-length", 0.2, "--json", tmp_path / "bench.json")
    assert (done.returncode, done.stdout) == (0, ""), done.stderr
    (line,) = json.loads((tmp_path / "bench.json").read_text())["lines"]
    assert (line["begin_s"], line["step_length_s"], line["vehicles_asked"]) == (30, 0.2, None)
    assert len(line["bare"]["measured"]) == len(line["equipped"]["measured"]) == 2


def test_copies_carry_as_many_times_the_vehicles_each_on_its_own(tmp_path):
    present = {}
    for count in (1, 3):
        folder = tmp_path / str(count)
        folder.mkdir()
        with Session(start_options(side_by_side(scenarios.load("highway"), count, folder), folder)) as session:
            while session.time < 120:
                session.step()
            roads = [libsumo.vehicle.getRoadID(v).lstrip(":") for v in libsumo.vehicle.getIDList()]
            assert libsumo.simulation.getCollidingVehiclesNumber() == 0
        present[count] = [sum(road.startswith(f"{k}/") for road in roads) for k in range(count)]
        assert sum(present[count]) == len(roads)
    (alone,) = present[1]
    assert alone > 100
    assert all(0.75 < some / alone < 1.33 for some in present[3])
    assert len({*present[3]}) > 1  # each has draws of its own


def test_a_world_is_warm_when_so_many_are_present(tmp_path):
    warming = partial(warm, scenarios.load("highway"), tmp_path / "w.xml", step_length=None, steps=1)
    (stretch,) = in_fresh_processes(tmp_path, [partial(warming, at=10.0, vehicles=30, limit=60.0)])
    assert 10 < stretch.begin < 60
    with Session(start_options(stretch.scenario, tmp_path)) as session:
        assert session.begin == stretch.begin
        assert 30 <= libsumo.vehicle.getIDCount() <= 33  # several can come in one step
    with pytest.raises(InputError, match="999 vehicles were not present in highway within 20 s"):
        in_fresh_processes(tmp_path, [partial(warming, at=10.0, vehicles=999, limit=20.0)])


def test_who_kills_a_process_does_not_hang_the_other(tmp_path):
    links = one, other = link()
    with pytest.raises(InputError, match="ended early, with exit code -9"):
        in_fresh_processes(tmp_path, [partial(_die, one), other.recv], links)


def _die(_: object) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.parametrize("wait", [0.0, 1.0])
def test_ctrl_c_ends_it_and_leaves_nothing(tmp_path, wait):
    arguments = [sys.executable, "-m", "aeb_sumo", "bench", "--vehicles", "20", "--repeat", "50"]
    environment = os.environ | {"TMPDIR": str(tmp_path)}
    with subprocess.Popen(arguments, env=environment, stderr=subprocess.PIPE, start_new_session=True) as process:
        while not any(tmp_path.glob("aeb-sumo-bench-*")):
            time.sleep(0.01)
        time.sleep(wait)
        os.killpg(process.pid, signal.SIGINT)
        _, errors = process.communicate(timeout=20)
    assert process.returncode == 130
    assert b"Traceback" not in errors
    assert not [*tmp_path.iterdir()]
    deadline = time.monotonic() + 5
    while alive(process.pid) and time.monotonic() < deadline:
        time.sleep(0.05)  # Python's own tracker of resources ends a moment later
    assert not alive(process.pid)


def alive(group: int) -> bool:
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["--scenario", "nope"], "unknown scenario 'nope'"),
        (["--scenario", "w0", "--sumocfg", "x.sumocfg"], "one of --scenario and --sumocfg"),
        (["--scenario", "w0", "--vehicles", "20"], "for the scenario highway only"),
        (["--strategy", "nope"], "unknown strategy 'nope'"),
        (["--strategy", "none,none"], "different values"),
        (["--vehicles", "0"], "whole numbers from 1"),
        (["--vehicles", "250,x"], "whole numbers from 1"),
        (["--vehicles", "250", "--from", "10"], "--from excludes --vehicles"),
        (["--from", "-1"], "0 or more seconds"),
        (["--steps", "0"], "--steps"),
        (["--repeat", "0"], "--repeat"),
        (["--step-length", "0"], "seconds from 0.001"),
        (["--step-length", "0.1,"], "different values"),
        (["--drivers", "nope"], "unknown driver profile"),
        (["--json", "/no/where.json"], "there is no folder /no"),
        (["--sumocfg", "nowhere.sumocfg"], "no such SUMO configuration"),
    ],
)
def test_bad_input_is_one_line(arguments, reason):
    done = command("bench", *arguments)
    assert (done.returncode, done.stdout) == (2, "")
    assert reason in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_a_world_nobody_is_in_is_refused():
    done = command("bench", "--scenario", "track", "--from", 500, "--quiet")
    assert done.returncode == 2
    assert "no vehicle is present in track at 500 s" in done.stderr
