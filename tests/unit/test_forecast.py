"""What planned runs will show."""

import numpy as np
import pandas as pd
import pytest

from aeb_sumo.campaign.execute import Outcome
from aeb_sumo.campaign.pilot import Pilot
from aeb_sumo.results import Results
from analysis.forecast import difference_half_width, forecast
from analysis.rates import poisson_rate


def figures(crashes, km=100.0):
    return pd.DataFrame({"crashes": np.asarray(crashes, float), "km": km}, index=range(1, len(crashes) + 1))


def test_of_independent_crashes_the_interval_to_come_is_the_exact_one():
    found = forecast(figures([4]), km=500.0)
    assert found.crashes == 20
    now, then = poisson_rate(4, 100.0), poisson_rate(20, 500.0)
    assert (found.low, found.high) == pytest.approx((500 * now.low, 500 * now.high))
    assert found.half_width == pytest.approx((then.high - then.low) / 2)


def test_without_a_crash_there_is_an_upper_bound():
    found = forecast(figures([0, 0]), km=1000.0)
    assert (found.crashes, found.low) == (0, 0)
    assert found.high == pytest.approx(1000 * poisson_rate(0, 200.0).high)
    assert found.half_width == pytest.approx(poisson_rate(0, 1000.0).high / 2)


def test_without_a_distance_nothing_is_known():
    assert np.isnan(forecast(figures([0], km=0.0), km=10.0).crashes)


def test_crashes_in_clusters_make_intervals_wide():
    even, clustered = (forecast(figures(c), km=4000.0) for c in ([5, 5, 5, 5], [20, 0, 0, 0]))
    assert even.crashes == clustered.crashes
    assert clustered.half_width > 3 * even.half_width
    assert clustered.high > 2 * even.high
    assert clustered.low < even.low


def test_the_width_is_what_campaigns_of_that_size_show():
    rng = np.random.default_rng(3)
    planned = forecast(figures(rng.poisson(20, 40)), km=2000.0)
    rates = rng.poisson(20, (4000, 20)).sum(axis=1) / 2000.0
    assert 0.93 < np.mean(np.abs(rates - 0.2) < planned.half_width) < 0.985


def test_pairs_of_like_seeds_make_the_difference_narrow():
    rng = np.random.default_rng(5)
    base = figures(rng.poisson(30, 12))
    other = figures(base["crashes"] - rng.binomial(1, 0.5, 12))
    told = {"seeds": 24, "baseline_km": 2400.0, "km": 2400.0}
    paired, by_pairs = difference_half_width(base, other, **told)
    apart, not_pairs = difference_half_width(base, other.set_axis(range(101, 113)), **told)
    assert (by_pairs, not_pairs) == (True, False)
    assert paired < apart / 3
    one = forecast(base, km=2400.0).half_width
    assert apart == pytest.approx(np.hypot(one, forecast(other, km=2400.0).half_width))


def pilot(times):
    rows = [{"run_id": "r", "begin_s": 10.0 * k, "end_s": 10.0 * (k + 1), "time_s": t, "distance_m": 10 * t}
            for k, t in enumerate(times)]  # fmt: skip
    outcome = Outcome(run_id="r", outcome="completed", cpu_s=5.0, start_s=1.0)
    return Pilot(
        seconds=40.0, outcome=outcome, results=Results.of({"runs": [{"run_id": "r", "begin_s": 0.0}], "traffic": rows})
    )


def test_a_pilot_stands_for_itself_and_its_last_quarter_for_what_comes_later():
    one = pilot([0.0, 10.0, 20.0, 30.0])
    assert one.km(40.0) == pytest.approx(0.6)
    assert one.km(100.0) == pytest.approx(0.6 + 6 * 0.3)
    assert one.cpu_s(40.0) == pytest.approx(5.0)
    assert one.cpu_s(100.0) == pytest.approx(1.0 + 4.0 * 240 / 60)


def test_a_pilot_in_which_nobody_drives_costs_by_time_alone():
    assert pilot([0.0] * 4).cpu_s(80.0) == pytest.approx(1.0 + 2 * 4.0)
    assert pilot([0.0] * 4).km(80.0) == 0
