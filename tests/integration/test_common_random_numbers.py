"""The same errors happen whatever the AEB does."""

import pytest

from aeb_sumo import scenarios
from aeb_sumo.drivers.encounters import FailureToYield, Riders, Warned
from aeb_sumo.drivers.lapses import Lapses
from aeb_sumo.drivers.reactions import Looming
from aeb_sumo.simulate import run


@pytest.fixture
def drawn(monkeypatch):
    """Every draw of the drivers: (what, who) -> values in the order of the driver's own clock."""
    log: dict[tuple, list] = {}
    following = Lapses._next

    def log_lapse(self, slot, vehicle, kind):
        following(self, slot, vehicle, kind)
        event = max(self._heap, key=lambda e: e.order)
        own = round(event.lapse.start - self._departed[vehicle], 6), round(event.lapse.end - event.lapse.start, 6)
        log.setdefault((self.kinds[kind].name, vehicle), []).append(own)

    monkeypatch.setattr(Lapses, "_next", log_lapse)
    for cls, name in (
        (FailureToYield, "driver_fails"), (FailureToYield, "rider_fails"), (FailureToYield, "notice"),
        (Riders, "runs_red"), (Warned, "delay"),
    ):  # fmt: skip
        monkeypatch.setattr(cls, name, _logged(getattr(cls, name), name, log))
    return log


def _logged(function, name, log):
    def call(self, seed, *who, **kind):
        value = function(self, seed, *who, **kind)
        log[(name, *who, *kind.values())] = [value]
        return value

    return call


@pytest.mark.parametrize(("name", "duration"), [("highway", 120), ("w0", 200)])
def test_no_draw_moves(name, duration, drawn):
    seen = {}
    for strategy, penetration in (("none", 1.0), ("zhao2025", 0.4), ("zhao2025", 1.0)):
        drawn.clear()
        run(scenarios.load(name), strategy, penetration=penetration, duration=duration)
        seen[strategy, penetration] = {what: list(draws) for what, draws in drawn.items()}
    baseline = seen["none", 1.0]
    assert sum(map(len, baseline.values())) > 10
    for other in seen.values():
        common = baseline.keys() & other.keys()
        assert len(common) > 0.5 * len(baseline)
        for what in common:
            n = min(len(baseline[what]), len(other[what]))
            assert baseline[what][:n] == other[what][:n]


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
