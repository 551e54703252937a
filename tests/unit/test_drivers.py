from itertools import islice

import numpy as np
import pytest

from aeb_sumo.drivers.errors import Errors, FailureToYield, Glances, HardBraking, Lapses, Robots
from aeb_sumo.drivers.streams import stream


def test_streams_depend_on_the_seed_and_the_names_alone():
    first = stream(1, "glance", "a").random(3)
    stream(1, "glance", "b").random(100)
    assert np.array_equal(first, stream(1, "glance", "a").random(3))
    assert not np.array_equal(first, stream(2, "glance", "a").random(3))
    assert not np.array_equal(stream(1, "ab", "c").random(3), stream(1, "a", "bc").random(3))


def test_glances_have_the_stated_distribution():
    glances = Glances()
    lapses = list(islice(glances.lapses(stream(1, "test"), "v"), 20_000))
    off = np.array([lapse.end - lapse.start for lapse in lapses]) - glances.reaction
    assert np.median(off) == pytest.approx(glances.median, rel=0.03)
    assert np.mean(off > 2.0) == pytest.approx(glances.over_two, abs=0.01)
    assert off.sum() / (lapses[-1].start + off[-1]) == pytest.approx(glances.share, rel=0.05)


def test_lapses_come_and_go_on_the_drivers_own_clock():
    lapses = Lapses(Errors(hard_braking=HardBraking(every=5.0, decel=4.0, duration=1.0)), seed=1)
    expected = next(HardBraking(every=5.0, decel=4.0, duration=1.0).lapses(stream(1, "hard_braking", "v"), "v"))
    lapses.depart(0, "v", 100.0)
    lapses.advance(100.0 + expected.start - 0.01)
    assert not lapses.erring()[0][0]
    lapses.advance(100.0 + expected.start + 0.01)
    erring, accel, away = lapses.erring()
    assert (erring[0], accel[0], away[0]) == (True, -4.0, False)
    assert lapses.name(0) == "hard_braking"
    lapses.leave(0, "v")
    lapses.advance(1e4)
    assert not lapses.erring()[0][0]


def test_the_first_kind_wins():
    lapses = Lapses(Errors(hard_braking=HardBraking(every=1e-3), robots=Robots()), seed=1)
    lapses.depart(0, "v", 0.0)
    lapses.advance(1.0)
    assert lapses.erring()[1][0] == -6.0


def test_failure_to_yield_is_one_draw_per_turn():
    error = FailureToYield(probability=0.3)
    drawn = [error.driver_fails(1, f"d{k}", "c") for k in range(3000)]
    assert np.mean(drawn) == pytest.approx(0.3, abs=0.03)
    assert drawn == [error.driver_fails(1, f"d{k}", "c") for k in range(3000)]


def test_names():
    assert Errors().names() == "attentive"
    assert Errors(glances=Glances(), hard_braking=HardBraking()).names() == "glance+hard_braking"
