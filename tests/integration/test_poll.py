"""Only those are read with whom a conflict is possible, and the results are those of reading everyone in every step."""

import libsumo
import numpy as np
import pytest

from aeb_sumo import scenarios
from aeb_sumo.errors import InputError
from aeb_sumo.results import TABLES
from aeb_sumo.simulate import run
from tests.helpers import approach, vehicle


def same_whoever_is_read(scenario, *args, **kwargs):
    """The results, if all their tables are the same both ways."""
    needed, every = (run(scenario, *args, poll=poll, **kwargs) for poll in ("needed", "every"))
    for name in TABLES:
        assert needed.tables[name].equals(every.tables[name]), name
    return needed


@pytest.mark.parametrize(
    ("scenario", "options"),
    [
        ("highway", {"strategy": "zhao2025", "duration": 150}),
        ("highway", {"strategy": "none", "seed": 3, "duration": 240}),
        ("highway", {"equip": "zhao2025=0.4,staged/fusion=0.3,lin2021=0.3", "seed": 2, "duration": 60}),
        ("w0", {"strategy": "zhao2025", "duration": 100}),
        ("b2", {"strategy": "yan2025", "duration": 90}),
        ("track", {"strategy": "staged", "sensing": "radar"}),
    ],
    ids=lambda value: value if isinstance(value, str) else "-".join(map(str, value.values())),
)
def test_the_same_as_reading_everyone(scenario, options):
    assert len(same_whoever_is_read(scenarios.load(scenario), **options).conflicts) > 0


def test_the_same_as_reading_everyone_in_bologna(bologna):
    result = same_whoever_is_read(scenarios.from_sumocfg(bologna / "run.sumocfg"), "zhao2025", duration=60)
    assert len(result.interventions) > 10


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 3])
@pytest.mark.parametrize(("scenario", "duration"), [("highway", 600), ("w0", 600)])
def test_the_same_in_long_runs(scenario, duration, seed):
    result = same_whoever_is_read(scenarios.load(scenario), "zhao2025", duration=duration, seed=seed)
    assert len(result.interventions) > 20
    assert len(result.crashes) > 0


@pytest.mark.slow
def test_the_same_in_a_long_run_in_bologna(bologna):
    result = same_whoever_is_read(scenarios.from_sumocfg(bologna / "run.sumocfg"), "zhao2025", duration=300)
    assert len(result.interventions) > 100


class Reads:
    """Counts who is read."""

    def attend(self, world):
        self.world, self.read, self.present = world, 0, 0

    def step(self, time):  # noqa: ARG002
        t = self.world.traffic
        self.read += int(np.count_nonzero((t.read_at == t.step) & t.here))
        self.present += len(t.present)


def test_few_are_read():
    reads = Reads()
    run(scenarios.load("highway"), "zhao2025", duration=60, trace=reads)
    assert 0 < reads.read < 0.1 * reads.present
    everyone = Reads()
    run(scenarios.load("highway"), "zhao2025", duration=20, trace=everyone, poll="every")
    assert everyone.read == everyone.present


def test_who_only_looks_on_changes_nothing():
    class LooksAtAll(Reads):
        def step(self, time):  # noqa: ARG002
            self.world.traffic.read(self.world.traffic.present)

    alone = run(scenarios.load("highway"), "zhao2025", duration=60)
    watched = run(scenarios.load("highway"), "zhao2025", duration=60, trace=LooksAtAll())
    for name in TABLES:
        assert alone.tables[name].equals(watched.tables[name]), name


def test_a_cut_in_is_found_within_the_search_cycle(on_track):
    """A car appears 12 m ahead: warned of within 0.2 s of search and 0.2 s of confirmation, and a step of each."""
    scene = vehicle("ego", 600, 25.0) + vehicle("late", 650, 10.0).replace('depart="0"', 'depart="1"')
    result = run(on_track(scene), "zhao2025", duration=4)
    first = result.interventions["begin_s"].min()
    assert 1.0 < first <= 1.0 + 0.2 + 0.2 + 0.2


def test_a_standing_queue_is_nobodys_conflict(on_track):
    stop = '<stop lane="track_0" duration="100"/>'
    standing = "".join(vehicle(f"v{k}", 600 + 8 * k, 0, inside=stop) for k in range(5))
    reads = Reads()
    run(on_track(standing), "zhao2025", duration=5, trace=reads)
    assert reads.read <= 5 * 3


def test_one_who_is_taken_away_behind_our_back_is_missed_at_once(on_track):
    class Takes(Reads):
        def step(self, time):
            if time > 1.0 and "gone" in self.world.traffic.slot:
                libsumo.vehicle.remove("gone")

    takes = Takes()
    run(on_track(vehicle("stays", 600, 10) + vehicle("gone", 640, 10)), "zhao2025", duration=3, trace=takes)
    assert set(takes.world.traffic.slot) == {"stays"}


def test_bad_poll():
    with pytest.raises(InputError, match="unknown poll 'all'; there are: needed, every"):
        run(scenarios.load("track"), poll="all")


def test_an_approach_is_watched_from_the_horizon_on(on_track):
    seen = []

    class Watch(Reads):
        def step(self, time):  # noqa: ARG002
            t, leads = self.world.traffic, self.world.leads
            if "ego" in t.slot and leads.lead[t.slot["ego"]] >= 0:
                slot = t.slot["ego"]
                seen.append((leads.gap[slot] / 20.0, bool(leads.possible[slot])))

    run(on_track(approach(72, 0, 140)), "none", duration=5, trace=Watch())
    far = [possible for ttc, possible in seen if ttc > 5.2]
    near = [possible for ttc, possible in seen if 0.5 < ttc < 4.7]
    assert far
    assert not any(far)
    assert near
    assert all(near)


@pytest.mark.parametrize("sensing", ["ideal", "fusion"])
def test_a_known_lead_is_a_target_as_soon_as_a_conflict_is_possible(on_track, sensing):
    first = []

    class Watch(Reads):
        def step(self, time):  # noqa: ARG002
            t = self.world.traffic
            slot = t.slot.get("ego")
            if slot is not None and self.world.leads.possible[slot] and not first:
                first.append(int(self.world.fleet.targets(np.array([slot])).slot[0]))
                assert first[0] == t.slot["lead"]

    run(on_track(approach(72, 0, 110)), "zhao2025", sensing=sensing, duration=4, trace=Watch())
    assert first
