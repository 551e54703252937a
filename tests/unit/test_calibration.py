import tomllib

import pytest

from aeb_sumo.calibration import ENOUGH, FITTED, GRID, TARGET, Observed, best, lines, with_value
from aeb_sumo.cli.calibrate import _set
from aeb_sumo.drivers import profile
from aeb_sumo.errors import InputError


def seen(near, crashes, **more):
    return Observed(near_crashes=near, crashes=crashes, **more)


def test_observations_add_up():
    both = seen(5, 1, away=2.0, glances=(0.5,), errors={"glance": 1}) + seen(
        7, 2, away=3.0, glances=(1.5,), errors={"glance": 1, "": 1}
    )
    assert (both.near_crashes, both.crashes, both.away, both.glances) == (12, 3, 5.0, (0.5, 1.5))
    assert both.errors == {"glance": 2, "": 1}
    assert both.ratio == 4.0


def test_the_best_is_the_nearest_as_a_factor():
    assert best([1.0, 2.0, 3.0], [seen(100, 20), seen(240, 20), seen(300, 20)]) == 2.0
    assert pytest.approx(9.28, abs=0.01) == TARGET


def test_a_ratio_of_a_few_crashes_is_not_known():
    assert best([1.0, 2.0], [seen(93, 10), seen(100, ENOUGH)]) == 2.0
    with pytest.raises(InputError, match=f"fewer than {ENOUGH} crashes with every value"):
        best([1.0], [seen(93, 10)])


def test_every_line_stands_without_any_data_too():
    for one in lines(Observed()):
        assert one.here
        assert one.evidence


def test_the_comparison_says_what_was_seen():
    some = seen(18, 2, away=18.0, driving=100.0, glances=(0.5, 0.8, 2.5), reactions=((1.0, 0.4, 0.2), (0.0, 0.6, 0.3)))
    text = {line.quantity.strip(): line.here for line in lines(some)}
    assert text["near-crashes per crash, primary, rear end"] == "9.0"
    assert text["time with the eyes off the road [%]"] == "18.0"
    assert text["glance, median [s]"] == "0.80"
    assert text["glances longer than 2 s [%]"] == "33.3"


def test_one_parameter_is_changed():
    changed = with_value(profile.load("highway"), FITTED, 1.25)
    assert changed.hard_braking.duration == 1.25
    assert changed.glances == profile.load("highway").glances
    with pytest.raises(InputError, match=r"driver profile careful has no section \[hard_braking\]"):
        with_value(profile.load("careful"), FITTED, 1.25)


def test_the_shipped_profile_is_one_that_the_fit_can_find():
    assert profile.load("highway").hard_braking.duration in GRID


@pytest.mark.parametrize("name", [n for n in profile.names() if profile.load(n).hard_braking])
def test_the_text_of_a_profile_keeps_all_but_the_value(name):
    before = profile.text(name)
    after = _set(before, FITTED, 1.75)
    old, new = tomllib.loads(before), tomllib.loads(after)
    assert new["hard_braking"].pop("duration") == 1.75
    old["hard_braking"].pop("duration", None)
    assert new == old
    assert before.count("#") == after.count("#")


def test_a_text_without_the_section_is_left_alone():
    assert _set("# [hard_braking]\n[glances]\n", FITTED, 1.0) == "# [hard_braking]\n[glances]\n"
