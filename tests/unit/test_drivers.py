from itertools import islice

import numpy as np
import pytest

from aeb_sumo.drivers.encounters import FailureToYield, Riders, Warned, lognormal
from aeb_sumo.drivers.lapses import Glances, HardBraking, Lapses, Robots
from aeb_sumo.drivers.streams import stream
from aeb_sumo.errors import InputError


def test_streams_depend_on_the_seed_and_the_names_alone():
    first = stream(1, "glance", "a").random(3)
    stream(1, "glance", "b").random(100)
    assert np.array_equal(first, stream(1, "glance", "a").random(3))
    assert not np.array_equal(first, stream(2, "glance", "a").random(3))
    assert not np.array_equal(stream(1, "ab", "c").random(3), stream(1, "a", "bc").random(3))


def test_glances_have_the_stated_distribution():
    glances = Glances()
    lapses = list(islice(glances.lapses(stream(1, "test"), "v"), 20_000))
    off = np.array([lapse.end - lapse.start for lapse in lapses])
    assert np.median(off) == pytest.approx(glances.median, rel=0.03)
    assert np.mean(off > 2.0) == pytest.approx(glances.over_two, abs=0.01)
    assert off.sum() / (lapses[-1].start + off[-1]) == pytest.approx(glances.share, rel=0.05)
    assert all(np.isnan(lapse.accel) for lapse in lapses[:10])


def test_who_never_looks_away_has_no_glances():
    assert list(Glances(share=0.0).lapses(stream(1, "test"), "v")) == []


def test_lapses_come_and_go_on_the_drivers_own_clock():
    kind = HardBraking(every=5.0, decel=4.0, duration=1.0)
    lapses = Lapses([kind], seed=1)
    expected = next(kind.lapses(stream(1, "hard_braking", "v"), "v"))
    lapses.depart(0, "v", 100.0)
    lapses.advance(100.0 + expected.start - 0.01)
    assert not lapses.on[0, 0]
    lapses.advance(100.0 + expected.start + 0.01)
    assert lapses.on[0, 0]
    assert lapses.accel[0, 0] == -4.0
    lapses.leave(0)
    lapses.advance(1e4)
    assert not lapses.on[0, 0]


def test_who_has_a_slot_after_another_has_his_own_lapses_alone():
    kind = HardBraking(every=5.0, decel=4.0, duration=1.0)
    lapses = Lapses([kind, Glances()], seed=1)
    braked = []
    lapses.depart(0, "first", 0.0)
    lapses.advance(50.0)
    lapses.leave(0)
    lapses.depart(0, "second", 50.0)
    for k in range(500):
        lapses.advance(50.0 + 0.1 * k)
        braked.append(lapses.on[0, 0])
        assert (lapses.decisive == {0: 0}) == lapses.on[0, 0]
    own = list(islice(kind.lapses(stream(1, "hard_braking", "second"), "second"), 50))
    assert braked == [any(lapse.start <= 0.1 * k < lapse.end for lapse in own) for k in range(500)]


def test_lapses_shorter_than_a_step_are_all_told():
    lapses = Lapses([Glances()], seed=1)
    lapses.depart(2, "v", 0.0)
    lapses.advance(1000.0)
    own = list(islice(Glances().lapses(stream(1, "glance", "v"), "v"), 1000))
    assert len(lapses.looked_away) == sum(lapse.start <= 1000.0 for lapse in own)
    assert len(lapses.looked_back) == sum(lapse.end <= 1000.0 for lapse in own)


def test_the_beginning_and_the_end_of_a_glance_are_told():
    lapses = Lapses([None, Glances(), Robots()], seed=1)
    assert lapses.glance == 0
    first = next(Glances().lapses(stream(1, "glance", "v"), "v"))
    lapses.depart(3, "v", 0.0)
    lapses.advance(first.start)
    assert (lapses.looked_away, lapses.looked_back) == ([3], [])
    lapses.advance(first.end)
    assert (lapses.looked_away, lapses.looked_back) == ([], [3])


def test_failure_to_yield_is_one_draw_per_driver_and_approach():
    error = FailureToYield(probability=0.3, motor=0.1)
    drawn = [error.driver_fails(1, f"d{k}", "c", "north", rider=True) for k in range(3000)]
    assert np.mean(drawn) == pytest.approx(0.3, abs=0.03)
    assert drawn == [error.driver_fails(1, f"d{k}", "c", "north", rider=True) for k in range(3000)]
    other = [error.driver_fails(1, f"d{k}", "c", "east", rider=True) for k in range(3000)]
    assert np.corrcoef(drawn, other)[0, 1] == pytest.approx(0.0, abs=0.05)
    motor = [error.driver_fails(1, f"d{k}", "c", "north", rider=False) for k in range(3000)]
    assert np.mean(motor) == pytest.approx(0.1, abs=0.02)


def test_the_time_to_notice_has_mean_and_deviation_of_the_source():
    times = [FailureToYield().notice(1, f"d{k}", "r") for k in range(5000)]
    assert np.mean(times) == pytest.approx(0.92, abs=0.02)
    assert np.std(times) == pytest.approx(0.28, abs=0.02)


def test_lognormal_of_mean_zero_is_zero():
    assert lognormal(stream(1, "x"), mean=0.0, sd=1.0) == 0.0


def test_warnings_reach_a_share_of_the_drivers():
    warned = Warned(responds=0.7)
    delays = np.array([warned.delay(1, f"d{k}", "t") for k in range(3000)])
    assert np.isfinite(delays).mean() == pytest.approx(0.7, abs=0.03)
    assert delays[np.isfinite(delays)].mean() == pytest.approx(warned.delay_mean, abs=0.03)


def test_more_drivers_reached_means_the_same_drivers_and_others():
    few, many = Warned(responds=0.3), Warned(responds=0.8)
    for k in range(200):
        if np.isfinite(few.delay(1, f"d{k}", "t")):
            assert many.delay(1, f"d{k}", "t") == few.delay(1, f"d{k}", "t")


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: Glances(share=1.2), "Glances.share must be within 0 .. 0.9, not 1.2"),
        (lambda: FailureToYield(probability=-0.1), "FailureToYield.probability must be within 0 .. 1, not -0.1"),
        (lambda: Riders(red_light=2.0), "Riders.red_light must be within 0 .. 1, not 2"),
        (lambda: Warned(responds=float("nan")), "Warned.responds must be within 0 .. 1, not nan"),
        (lambda: HardBraking(every=0.0), "HardBraking.every must be"),
    ],
)
def test_values_out_of_range_are_named(make, field):
    with pytest.raises(InputError) as error:
        make()
    assert str(error.value).startswith(field)
