"""A fork of the world is the world."""

import os
import re
import resource
import signal
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from aeb_sumo import scenarios
from aeb_sumo.scenarios import from_sumocfg
from aeb_sumo.simulate import run
from aeb_sumo.world.fork import Answer, Forks, obstacle

AHEAD = 10.0  # s


class Twins:
    """Forks the world at some instants and compares every state of the next seconds in both."""

    def __init__(self, *instants):
        self.instants, self.compared, self.vehicles = instants, 0, 0
        self._forks = Forks(limit=1)
        self._numbers, self._own, self._later = {}, {}, []

    def attend(self, world):
        self.world = world

    def step(self, time):
        self._own[time] = self._state()
        for instant in self.instants:
            if abs(time - instant) < 1e-6:
                self._numbers[self._forks.split(self._life)] = time
                self.vehicles += len(self.world.traffic.present)
        for number, answer in self._forks.answers().items():
            self.check(answer, self._numbers[number])

    def _life(self):
        states, until = {}, self.world.time + AHEAD
        while self.world.time < until:
            self.world.act()
            self.world.observe()
            self.world.decide()
            states[self.world.time] = self._state()
        return states

    def _state(self):
        w, t = self.world, self.world.traffic
        rows = t.present
        t.read(rows)
        state = np.column_stack([t.x[rows], t.y[rows], t.heading[rows], t.speed[rows], w.fleet.decel[rows]])
        return [t.ids[s] for s in rows.tolist()], state.tobytes()

    def check(self, answer, since):
        assert answer.failure == ""
        self._later.append((since, answer.value))

    def finish(self):
        for number, answer in self._forks.answers(wait=True).items():
            self.check(answer, self._numbers[number])
        for since, states in self._later:
            for when, state in states.items():
                if when in self._own:
                    assert state == self._own[when], f"forked at {since}, differs at {when}"
                    self.compared += 1


@pytest.mark.parametrize("name", ["highway", "w0", "221"], ids=["highway: lane-based", "w0: sublane", "221: sublane"])
def test_the_forked_world_equals_its_parent_bit_for_bit(name):
    twins = Twins(10.0, 25.0, 26.0, 40.0)
    run(scenarios.load(name), "zhao2025", duration=52, seed=2, trace=twins)
    twins.finish()
    assert twins.compared > 390
    assert twins.vehicles > 20


def test_the_forked_world_of_a_city_equals_its_parent(bologna):
    twins = Twins(20.0)
    run(from_sumocfg(bologna / "run.sumocfg"), "zhao2025", duration=32, step_length=0.2, trace=twins)
    twins.finish()
    assert twins.compared >= 50
    assert twins.vehicles > 20


class Splitting:
    """Forks the world in every so many steps and lets it go on for a while."""

    def __init__(self, every):
        self.every, self.steps, self.forks = every, 0, Forks(limit=1)

    def attend(self, world):
        self.world = world

    def step(self, time):  # noqa: ARG002
        self.steps += 1
        if self.steps % self.every == 0:
            self.forks.split(self._life)

    def _life(self):
        for _ in range(250):
            self.world.act()
            self.world.observe()
            self.world.decide()
        return self.world.time


def test_forks_read_and_write_nothing_of_their_parents_files(tmp_path):
    """SUMO reads routes and writes outputs while it runs."""
    net = scenarios.load("track").options[1]
    (edge,) = re.findall(r'<edge id="([^":]+)"', Path(net).read_text(encoding="utf-8"))[:1]
    # So long that SUMO, which reads 1 MiB at once, reads on every 200 s.
    flow = "".join(
        f'<vehicle id="v{n}" type="t" depart="{n * 4}"><route edges="{edge}"/><!--{n:020000}--></vehicle>\n'
        for n in range(500)
    )
    (tmp_path / "v.rou.xml").write_text(f'<routes><vType id="t" vClass="passenger"/>{flow}</routes>', encoding="utf-8")
    (tmp_path / "my.sumocfg").write_text(
        f'<configuration><input><net-file value="{net}"/><route-files value="v.rou.xml"/></input>'
        '<output><fcd-output value="fcd.xml"/><tripinfo-output value="trips.xml"/></output></configuration>',
        encoding="utf-8",
    )
    written = {}
    for name, trace in (("alone", None), ("forked", Splitting(every=100))):
        (tmp_path / name).mkdir()
        run(
            from_sumocfg(tmp_path / "my.sumocfg"), "none", step_length=1.0, duration=700, trace=trace,
            sumo_output=tmp_path / name,
        )  # fmt: skip
        # All but the heading, which tells the time of day and the folder.
        written[name] = {p.name: p.read_text().partition("-->")[2] for p in (tmp_path / name).iterdir()}
    assert trace.forks.answers(wait=True).keys() >= {1}
    assert len(written["alone"]["fcd.xml"]) > 10_000
    assert written["alone"] == written["forked"]


def test_a_fork_that_dies_raises_or_hangs_is_a_failure_with_its_reason():
    def dies():
        os.kill(os.getpid(), signal.SIGKILL)

    def raises():
        raise ValueError("no\nway")

    def hangs():
        time.sleep(60)

    forks = Forks(limit=4, patience=0.5)
    numbers = [forks.split(life) for life in (dies, raises, lambda: 42, hangs)]
    answers = forks.answers(wait=True)
    assert [answers[n] for n in numbers] == [
        Answer(failure="the fork was ended by signal 9"),
        Answer(failure="ValueError: no way"),
        Answer(42),
        Answer(failure="the fork was not done within 0.5 s"),
    ]
    assert len(forks) == 0


def test_forks_are_bounded_in_number():
    forks = Forks(limit=2)
    alive = []
    for _ in range(5):
        forks.split(lambda: time.sleep(0.05))
        alive.append(len(forks))
    assert max(alive) == 2
    assert len(forks.answers(wait=True)) == 5


def test_given_up_forks_are_gone():
    forks = Forks(limit=2)
    forks.split(lambda: time.sleep(60))
    (child,) = forks._children.values()
    forks.end("given up")
    assert forks.answers() == {1: Answer(failure="given up")}
    assert not Path(f"/proc/{child.pid}").exists()


def test_sumo_with_several_threads_cannot_be_forked():
    reasons = []

    class Asks:
        def attend(self, world):  # noqa: ARG002
            reasons.append(obstacle())

        def step(self, time):
            pass

    scenario = scenarios.load("track")
    run(scenario, "none", duration=0.5, trace=Asks())
    options = (*scenario.options, "--device.rerouting.threads", "2")
    run(replace(scenario, options=options), "none", duration=0.5, trace=Asks())
    assert reasons == ["", "SUMO runs with 2 device.rerouting.threads, and a world is forked with one only"]


def test_a_fork_asleep_keeps_the_world_as_it_was_until_it_is_woken_or_dismissed():
    world = {"time": 1}
    forks = Forks(limit=1)
    kept, unneeded = (forks.split(lambda: world["time"], asleep=True) for _ in range(2))
    world["time"] = 2
    assert forks.answers(wait=True) == {}
    forks.dismiss(unneeded)
    forks.wake(kept)
    assert forks.answers(wait=True) == {kept: Answer(1)}


def test_a_fork_that_dies_asleep_is_a_failure_once_it_is_woken():
    forks = Forks(limit=1)
    number = forks.split(lambda: 1, asleep=True)
    os.kill(forks._asleep[number].pid, signal.SIGKILL)
    time.sleep(0.05)
    forks.wake(number)
    assert forks.answers(wait=True) == {number: Answer(failure="the fork was ended by signal 9")}


def test_a_fork_that_cannot_be_made_is_a_failure_and_can_be_dismissed_before_and_after_it_is_known():
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    forks = Forks(limit=1)
    before = sorted(Path("/proc/self/fd").iterdir())
    free = [os.dup(0) for _ in range(3)]  # enough for the first pipe, not for the second
    for fd in free:
        os.close(fd)
    resource.setrlimit(resource.RLIMIT_NOFILE, (free[-1] + 1, hard))
    try:
        known, unknown = (forks.split(lambda: 1, asleep=True) for _ in range(2))
        forks.dismiss(unknown)
        assert forks.answers() == {known: Answer(failure="the world could not be forked: Too many open files")}
        forks.dismiss(known)
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    assert sorted(Path("/proc/self/fd").iterdir()) == before


def test_a_program_with_thousands_of_open_files_can_fork():
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if hard < 1200:
        pytest.skip(f"no more than {hard} files may be open here")
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, 1200), hard))
    taken = [os.dup(0) for _ in range(1100)]
    try:
        forks = Forks(limit=1)
        number = forks.split(lambda: 1)
        assert forks.answers(wait=True) == {number: Answer(1)}
    finally:
        for fd in taken:
            os.close(fd)
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
