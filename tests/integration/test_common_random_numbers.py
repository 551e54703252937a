"""The same errors happen whatever the AEB does."""

import pytest

from aeb_sumo import scenarios
from aeb_sumo.drivers.errors import FailureToYield, Lapses
from aeb_sumo.drivers.streams import stream
from aeb_sumo.equipment import Equipment
from aeb_sumo.simulate import run


@pytest.fixture
def drawn(monkeypatch):
    """Every draw of the error layer, by driver, in the order of the driver's own clock."""
    log: dict[str, list] = {}
    following, failing = Lapses._next, FailureToYield.driver_fails

    def log_lapse(self, slot, vehicle, kind):
        following(self, slot, vehicle, kind)
        event = max(self._heap, key=lambda e: e.order)
        own = round(event.lapse.start - self._departed[vehicle], 6), round(event.lapse.end - event.lapse.start, 6)
        log.setdefault(vehicle, []).append((kind, *own))

    def log_failure(self, seed, driver, junction):
        fails = failing(self, seed, driver, junction)
        log.setdefault(driver, []).append((junction, fails))
        return fails

    monkeypatch.setattr(Lapses, "_next", log_lapse)
    monkeypatch.setattr(FailureToYield, "driver_fails", log_failure)
    return log


@pytest.mark.parametrize(("name", "duration"), [("highway", 120), ("w0", 200)])
def test_no_draw_moves(name, duration, drawn):
    seen = {}
    for equip in (Equipment(), "zhao2025=1", "zhao2025/radar=0.3,yan2025=0.3,truck:staged=0.5"):
        drawn.clear()
        run(scenarios.load(name), equip=equip, duration=duration)
        seen[equip] = {vehicle: list(draws) for vehicle, draws in drawn.items()}
    baseline = seen.pop(Equipment())
    assert sum(map(len, baseline.values())) > 10
    for other in seen.values():
        assert_no_draw_moved(baseline, other)


def assert_no_draw_moved(one, two):
    for vehicle in one.keys() & two.keys():
        n = min(len(one[vehicle]), len(two[vehicle]))
        assert one[vehicle][:n] == two[vehicle][:n]


def test_one_more_equipped_vehicle_changes_nobody_elses_draws_and_systems(drawn, monkeypatch):
    """The shares differ by so little that one vehicle is between them; it brakes, so the traffic is another."""
    carried: dict[str, str] = {}
    following = Equipment.of

    def log_system(self, vehicle, **kind):
        system = following(self, vehicle, **kind)
        carried[vehicle] = system.name if system else ""
        return system

    monkeypatch.setattr(Equipment, "of", log_system)
    one, edge = "main_car.43", stream(1, "equip", "main_car.43").random() - 0.1
    results, draws, systems = [], [], []
    for share in (edge - 1e-6, edge + 1e-6):
        drawn.clear()
        carried.clear()
        results.append(run(scenarios.load("highway"), equip=f"zhao2025=0.1,zheng2020={share}", duration=75))
        draws.append({vehicle: list(d) for vehicle, d in drawn.items()})
        systems.append(dict(carried))
    assert {v: s for v, s in systems[1].items() if systems[0][v] != s} == {one: "zheng2020"}
    assert results[1].runs["equipped"].item() - results[0].runs["equipped"].item() == 1
    assert results[1].interventions.query("vehicle == @one")["brake_s"].notna().any()
    assert not results[0].traffic["speed_mps"].equals(results[1].traffic["speed_mps"])
    assert_no_draw_moved(*draws)


def test_a_car_equipped_at_one_share_is_so_at_every_larger_one():
    equipped = {}
    for share in (0.2, 0.6):
        result = run(scenarios.load("highway"), "zhao2025", penetration=share, duration=60)
        equipped[share] = result.runs["equipped"].item()
    assert 0 < equipped[0.2] < equipped[0.6]
