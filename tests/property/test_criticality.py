"""Laws of the measures of criticality."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aeb_sumo.criticality import crossing_ttc, drac, required_decel, ttc, ttc2, yielding_decel

gaps = st.floats(0.1, 200)
speeds = st.floats(0, 50)
accels = st.floats(-10, 5)


def smallest_gap(gap, speed, lead_speed, lead_accel, decel, dt=0.002):
    """By stepping both until the ego stands."""
    t = np.arange(0, min(speed / decel, 60.0), dt)
    lead_t = np.minimum(t, lead_speed / -lead_accel) if lead_accel < 0 else t
    lead = lead_speed * lead_t + lead_accel * lead_t**2 / 2
    return (gap + lead - (speed * t - decel * t**2 / 2)).min()


@given(gap=gaps, speed=speeds, lead_speed=speeds, lead_accel=accels)
def test_the_required_deceleration_just_avoids_contact(gap, speed, lead_speed, lead_accel):
    decel = float(required_decel(gap=gap, speed=speed, lead_speed=lead_speed, lead_accel=lead_accel))
    assume(0.2 < decel < 100)
    assert smallest_gap(gap, speed, lead_speed, lead_accel, decel * 1.001) > -0.01
    assert smallest_gap(gap, speed, lead_speed, lead_accel, decel * 0.9) < 0.01


@given(gap=gaps, speed=speeds, lead_speed=speeds)
def test_at_constant_speed_of_the_lead_it_is_the_drac(gap, speed, lead_speed):
    answer = required_decel(gap=gap, speed=speed, lead_speed=lead_speed, lead_accel=0.0)
    assert answer == pytest.approx(drac(gap=gap, closing_speed=speed - lead_speed))


@given(gap=gaps, speed=speeds, lead_speed=speeds, accel=accels, harder=st.floats(0, 5))
def test_a_lead_that_brakes_harder_never_demands_less(gap, speed, lead_speed, accel, harder):
    """A braking lead never counts as an accelerating one."""

    def both(a):
        decel = required_decel(gap=gap, speed=speed, lead_speed=lead_speed, lead_accel=a)
        return decel, ttc2(gap=gap, closing_speed=speed - lead_speed, closing_accel=-a)

    (mild, late), (hard, early) = both(accel), both(accel - harder)
    assert hard >= mild - 1e-9
    assert early <= late + 1e-9


@given(gap=gaps, speed=speeds, lead_speed=speeds, accel=accels, nearer=st.floats(0, 50))
def test_nearer_is_never_safer(gap, speed, lead_speed, accel, nearer):
    def measures(g):
        required = required_decel(gap=g, speed=speed, lead_speed=lead_speed, lead_accel=accel)
        closing = speed - lead_speed
        return np.array([required, drac(gap=g, closing_speed=closing), -ttc(gap=g, closing_speed=closing)])

    assert (measures(gap) >= measures(gap + nearer) - 1e-9).all()


@given(distance=gaps, speed=st.floats(0.5, 50), until=st.floats(0.1, 30), longer=st.floats(0, 30))
def test_who_yields_is_not_there_before_it_is_free(distance, speed, until, longer):
    decel = float(yielding_decel(distance=distance, speed=speed, until=until))
    t = min(until, speed / decel) if decel > 0 else until
    assert speed * t - decel * t**2 / 2 <= distance * (1 + 1e-9)
    assert yielding_decel(distance=distance, speed=speed, until=until + longer) >= decel * (1 - 1e-9)
    assert yielding_decel(distance=distance, speed=speed) >= decel * (1 - 1e-9)


@given(st.lists(st.floats(0, 20), min_size=4, max_size=4))
def test_crossing_ttc_does_not_know_who_is_the_other(times):
    enter, leave, other_enter, other_leave = times
    one = crossing_ttc(enter=enter, leave=leave, other_enter=other_enter, other_leave=other_leave)
    assert one == crossing_ttc(enter=other_enter, leave=other_leave, other_enter=enter, other_leave=leave)
    assert one == np.inf or one >= max(enter, other_enter)


@given(arrays(float, (3, 2, 4), elements=st.floats(allow_infinity=True, allow_nan=True)))
def test_values_broadcast_and_each_answer_stands_for_itself(values):
    gap, speed, accel = values[0], values[1][:, :1], values[2][0]
    together = ttc2(gap=gap, closing_speed=speed, closing_accel=accel)
    assert together.shape == (2, 4)
    for i, j in np.ndindex(2, 4):
        alone = ttc2(gap=gap[i, j], closing_speed=speed[i, 0], closing_accel=accel[j])
        assert alone.shape == ()
        np.testing.assert_array_equal(alone, together[i, j])
