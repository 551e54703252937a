"""What a vehicle knows of the one ahead after searches; the formulas as `Leads` states them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aeb_sumo.world.leads import CLOSE, _judge

DT, HORIZON = 0.1, 5.0


class Known:
    """One vehicle's row."""

    def __init__(self):
        self.found, self.found_at, self.lead = np.array([-1]), np.zeros(1, np.int64), np.array([-1])
        self.found_gap, self.gap, self.rate = np.zeros(1), np.zeros(1), np.zeros(1)
        self.known, self.watching = np.zeros(1, np.bool_), np.zeros(1, np.bool_)

    def search(self, step, lead, gap, closing=0.0):
        _judge(
            np.zeros(1, np.int64), np.array([lead]), np.array([gap - 2.5]), np.array([closing]), np.array([2.5]),
            np.array([HORIZON]), step, DT, self.found, self.found_at, self.found_gap, self.rate, self.known,
            self.watching, self.lead, self.gap,
        )  # fmt: skip
        return bool(self.watching[0])


@settings(deadline=None)  # the first call compiles
@given(gap=st.floats(5.0, 150.0), closing=st.floats(-20.0, 40.0))
def test_a_new_lead_is_watched_if_both_touch_within_the_horizon(gap, closing):
    known = Known()
    watched = known.search(1, 7, gap, closing)
    if abs(gap - CLOSE - closing * HORIZON) > 1e-6:
        assert watched == (gap < CLOSE + closing * HORIZON)
    assert (known.lead[0], known.rate[0], known.known[0]) == (7, closing, False)
    assert known.gap[0] == pytest.approx(gap)


@settings(deadline=None)  # the first call compiles
@given(gap=st.floats(60.0, 150.0), rate=st.floats(1.0, 10.0), more=st.floats(0.1, 10.0))
def test_a_rate_that_grows_counts_and_one_that_falls_does_not(gap, rate, more):
    for growth in (more, -more):
        known, gaps = Known(), [gap, gap - rate * 0.2, gap - (2 * rate + growth * 0.2) * 0.2]
        for k, each in enumerate(gaps):
            watched = known.search(2 * k, 7, each, rate)
        now = rate + growth * 0.2
        reach = max(now * HORIZON, now * 4.0 + max(growth, 0.0) * 8.0)
        assert known.known[0]
        assert known.rate[0] == pytest.approx(now, abs=1e-6)
        if abs(gaps[2] - CLOSE - reach) > 1e-6:
            assert watched == (gaps[2] < CLOSE + reach)


def test_who_stands_close_behind_another_who_stands_is_in_no_conflict():
    known = Known()
    assert not any(known.search(k, 7, 1.5) for k in range(5))
    assert known.search(5, 7, 1.4)


def test_nobody_ahead_is_no_conflict_and_no_gap():
    known = Known()
    known.search(1, 7, 10.0, 20.0)
    assert not known.search(2, -1, np.inf)
    assert (known.lead[0], known.gap[0]) == (-1, np.inf)
    assert np.isnan(known.rate[0])
