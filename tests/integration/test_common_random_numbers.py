"""The same errors happen whatever the AEB does."""

import pytest

from aeb_sumo import scenarios
from aeb_sumo.drivers.errors import FailureToYield, Lapses
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


@pytest.mark.parametrize(("name", "duration"), [("highway", 120), ("w0", 300)])
def test_no_draw_moves(name, duration, drawn):
    seen = {}
    for strategy, penetration in (("none", 1.0), ("zhao2025", 0.4), ("zhao2025", 1.0)):
        drawn.clear()
        run(scenarios.load(name), strategy, penetration=penetration, duration=duration)
        seen[strategy, penetration] = {vehicle: list(draws) for vehicle, draws in drawn.items()}
    baseline = seen["none", 1.0]
    assert sum(map(len, baseline.values())) > 10
    for other in seen.values():
        for vehicle in baseline.keys() & other.keys():
            n = min(len(baseline[vehicle]), len(other[vehicle]))
            assert baseline[vehicle][:n] == other[vehicle][:n]


def test_a_car_equipped_at_one_share_is_so_at_every_larger_one():
    equipped = {}
    for share in (0.2, 0.6):
        result = run(scenarios.load("highway"), "zhao2025", penetration=share, duration=60)
        equipped[share] = result.runs["equipped"].item()
    assert 0 < equipped[0.2] < equipped[0.6]
