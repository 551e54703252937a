"""The same errors happen whatever the AEB does."""

import pytest

from aeb_sumo import scenarios
from aeb_sumo.drivers.encounters import FailureToYield, Riders, Warned
from aeb_sumo.drivers.lapses import Glances, HardBraking
from aeb_sumo.drivers.reactions import Looming
from aeb_sumo.drivers.streams import stream
from aeb_sumo.equipment import Equipment
from aeb_sumo.simulate import run


@pytest.fixture
def drawn(monkeypatch):
    """Every draw of the drivers: (what, who) -> values in the order of the driver's own clock."""
    log: dict[tuple, list] = {}
    for kind in (Glances, HardBraking):
        monkeypatch.setattr(kind, "lapses", _logged_lapses(kind.lapses, log))
    for cls, name in (
        (FailureToYield, "driver_fails"), (FailureToYield, "rider_fails"), (FailureToYield, "notice"),
        (Riders, "runs_red"), (Warned, "delay"),
    ):  # fmt: skip
        monkeypatch.setattr(cls, name, _logged(getattr(cls, name), name, log))
    return log


def _logged_lapses(function, log):
    def call(self, draw, driver):
        for lapse in function(self, draw, driver):
            log.setdefault((self.name, driver), []).append((lapse.start, lapse.end))
            yield lapse

    return call


def _logged(function, name, log):
    def call(self, seed, *who, **kind):
        value = function(self, seed, *who, **kind)
        log[(name, *who, *kind.values())] = [value]
        return value

    return call


@pytest.mark.parametrize(("name", "duration"), [("highway", 120), ("w0", 200)])
def test_no_draw_moves(name, duration, drawn):
    seen = {}
    for equip in (Equipment(), "zhao2025=1", "zhao2025/radar=0.3,yan2025=0.3,truck:staged=0.5"):
        drawn.clear()
        run(scenarios.load(name), equip=equip, duration=duration)
        seen[equip] = {what: list(draws) for what, draws in drawn.items()}
    baseline = seen.pop(Equipment())
    assert sum(map(len, baseline.values())) > 10
    for other in seen.values():
        assert_no_draw_moved(baseline, other)


def assert_no_draw_moved(one, two):
    common = one.keys() & two.keys()
    assert len(common) > 0.5 * len(one)
    for what in common:
        n = min(len(one[what]), len(two[what]))
        assert one[what][:n] == two[what][:n]


def test_one_more_equipped_vehicle_changes_nobody_elses_draws_and_systems(drawn, monkeypatch):
    """The shares differ by so little that one vehicle is between them, and that one's AEB acts."""
    carried: dict[str, str] = {}
    following = Equipment.of

    def log_system(self, vehicle, **kind):
        system = following(self, vehicle, **kind)
        carried[vehicle] = system.name if system else ""
        return system

    def ran(share, duration, **watch):
        drawn.clear()
        carried.clear()
        equip = f"lin2021=0.1,zheng2020={share}"
        result = run(scenarios.load("highway"), equip=equip, duration=duration, seed=1, **watch)
        return result, {key: list(d) for key, d in drawn.items()}, dict(carried)

    monkeypatch.setattr(Equipment, "of", log_system)
    ended = [0]
    everyone, _, _ = ran(0.9, 300, progress=lambda p: ended.append(p.interventions), stop=lambda: ended[-1] > 0)
    first = everyone.interventions.query("strategy == 'zheng2020'").sort_values("begin_s").iloc[0]
    share = stream(1, "equip", first["vehicle"]).random() - 0.1
    span = everyone.runs["end_s"].item() + 5
    (without, draws, systems), (with_it, other_draws, other_systems) = ran(share - 1e-6, span), ran(share + 1e-6, span)
    changed = {v: s for v, s in other_systems.items() if systems.get(v, s) != s}
    assert changed == {first["vehicle"]: "zheng2020"}
    assert first["vehicle"] in set(with_it.interventions["vehicle"]) - set(without.interventions["vehicle"])
    assert_no_draw_moved(draws, other_draws)


def test_reactions_to_the_same_vehicle_are_the_same_draws(monkeypatch):
    """How a driver reacts depends on the threat; what he draws does not."""
    log: dict[str, dict] = {}
    respond = Looming.respond

    def logged(self, driver, encounter, threat):
        key = int(encounter.bit_generator.state["state"]["key"][0])
        response = respond(self, driver, encounter, threat)
        log[strategy][key] = response.decel, response.jerk_per_looming
        return response

    monkeypatch.setattr(Looming, "respond", logged)
    for strategy in ("none", "yan2025"):
        log[strategy] = {}
        run(scenarios.load("highway"), strategy, penetration=0.5, duration=200)
    common = log["none"].keys() & log["yan2025"].keys()
    assert len(common) > 3
    assert all(log["none"][key] == log["yan2025"][key] for key in common)


def test_a_car_equipped_at_one_share_is_so_at_every_larger_one():
    equipped = {}
    for share in (0.2, 0.6):
        result = run(scenarios.load("highway"), "zhao2025", penetration=share, duration=60)
        equipped[share] = result.runs["equipped"].item()
    assert 0 < equipped[0.2] < equipped[0.6]
