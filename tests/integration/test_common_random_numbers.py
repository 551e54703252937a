"""The same errors happen whatever the AEB does."""

import pytest

from aeb_sumo import scenarios
from aeb_sumo.drivers.encounters import FailureToYield
from aeb_sumo.drivers.lapses import Lapses
from aeb_sumo.drivers.streams import stream
from aeb_sumo.equipment import Equipment
from aeb_sumo.simulate import run


@pytest.fixture
def drawn(monkeypatch):
    """Every draw of the error layer, by driver (and encounter), in the order of the driver's own clock."""
    log: dict[str, list] = {}
    following, failing = Lapses._next, FailureToYield.driver_fails

    def log_lapse(self, slot, vehicle, kind):
        following(self, slot, vehicle, kind)
        event = max(self._heap, key=lambda e: e.order)
        own = round(event.lapse.start - self._departed[vehicle], 6), round(event.lapse.end - event.lapse.start, 6)
        log.setdefault(vehicle, []).append((kind, *own))

    def log_failure(self, seed, driver, junction, approach, *, rider):
        fails = failing(self, seed, driver, junction, approach, rider=rider)
        log.setdefault(f"{driver} {junction} {approach} {rider}", []).append(fails)
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
    for key in one.keys() & two.keys():
        n = min(len(one[key]), len(two[key]))
        assert one[key][:n] == two[key][:n]


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


def test_a_car_equipped_at_one_share_is_so_at_every_larger_one():
    equipped = {}
    for share in (0.2, 0.6):
        result = run(scenarios.load("highway"), "zhao2025", penetration=share, duration=60)
        equipped[share] = result.runs["equipped"].item()
    assert 0 < equipped[0.2] < equipped[0.6]
