from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import t as student
from statsmodels.stats.rates import confint_poisson_2indep

import analysis
from analysis.planning import relative_half_width


def test_three_seeds_have_the_t_interval_of_their_differences():
    """-1, -3 and -2: mean -2, standard deviation 1."""
    found = analysis.paired_interval([4, 6, 8], [3, 3, 6])
    half = 4.302653 / np.sqrt(3)
    assert (found.estimate, found.low, found.high) == pytest.approx((-2, -2 - half, -2 + half), rel=1e-6)
    assert (found.seeds, found.method, found.note) == (3, "t by seed", "few seeds: may be too narrow")


def test_percent_is_the_jackknife_of_the_log_ratio():
    """Without the first seed the ratio is 1, without one of the others 5/6."""
    found = analysis.paired_interval([10, 20, 20], [5, 20, 20], percent=True)
    factor = np.exp(4.3026527 * np.log(6 / 5) * 2 / 3)
    assert found.estimate == pytest.approx(-10)
    assert (found.low, found.high) == pytest.approx((90 / factor - 100, 90 * factor - 100), rel=1e-6)


def test_two_seeds_say_nothing_of_a_percentage():
    found = analysis.paired_interval([10, 20], [5, 20], percent=True)
    assert found.estimate == pytest.approx(-100 / 6)
    assert np.isnan([found.low, found.high]).all()
    assert found.note == "two seeds say nothing of a percentage"


def test_the_bootstrap_draws_from_all_resamples():
    """Every one of the 6^6 resamples counted, against those drawn."""
    each = np.array([1.0, 2.5, 3.0, 5.0, 4.5, 2.2])
    resamples = each[np.array(list(product(range(6), repeat=6)))]
    spread, error = resamples.std(axis=1) / np.sqrt(5), each.std(ddof=1) / np.sqrt(6)
    shift = resamples.mean(axis=1) - each.mean()
    t = np.divide(shift, spread, out=np.copysign(np.inf, shift), where=spread > 0)
    low, high = np.quantile(t, [0.025, 0.975], method="inverted_cdf")
    found = analysis.paired_interval(np.zeros(6), each)
    assert found.method == "studentized bootstrap by seed"
    expected = (each.mean() - high * error, each.mean() - low * error)
    assert (found.low, found.high) == pytest.approx(expected, abs=0.1)


def test_the_bootstrap_is_limited_to_twice_t():
    """Three seeds of four agree, so that one resample in three has no spread."""
    found = analysis.paired_interval([0, 0, 0, 0], [0, 0, 0, 4])
    assert found.high == pytest.approx(1 + 2 * 3.182446 * 1.0)
    assert found.low <= 1 <= found.high


def test_seeds_in_another_order_are_the_same_seeds():
    a, b = np.array([3.0, 1, 4, 1, 5, 9, 2]), np.array([2.0, 7, 1, 8, 2, 8, 1])
    per = np.arange(1.0, 8)
    for percent in (False, True):
        one = analysis.paired_interval(a, b, baseline_per=per, percent=percent)
        assert one == analysis.paired_interval(a[::-1], b[::-1], baseline_per=per[::-1], percent=percent)


def test_a_rate_is_sum_by_sum_and_knows_that_weights_differ():
    found = analysis.paired_interval([10, 10], [30, 60], baseline_per=[5, 5], other_per=[10, 20])
    assert found.estimate == pytest.approx(90 / 30 - 20 / 10)
    assert np.isnan(found.low), "the rate is 3 in both seeds, and 2 in the baseline: no spread"
    found = analysis.paired_interval([10, 10], [30, 90], baseline_per=[5, 5], other_per=[10, 20])
    # Each seed's share in the difference: (30 - 40, 90 - 80) / 15 + 2.
    assert found.estimate == pytest.approx(2)
    assert found.high - 2 == pytest.approx(student.ppf(0.975, 1) * 2 / 3)


@pytest.mark.parametrize(
    ("baseline", "other", "percent", "estimate", "note"),
    [
        ([5], [3], False, -2, "one seed has no spread"),
        ([5], [3], True, -40, "one seed has no spread"),
        ([5, np.nan], [3, 1], False, -2, "one seed has no spread"),
        ([5, 6, 7], [3, 4, 5], False, -2, "no spread between the seeds"),
        ([0, 0, 0], [0, 0, 0], False, 0, "no spread between the seeds"),
        ([2, 4, 6], [1, 2, 3], True, -50, "no spread between the seeds"),
        ([2, 4, 6], [0, 0, 0], True, -100, "nothing left of it"),
        ([0, 0, 0], [1, 2, 3], True, np.nan, "nothing in the baseline"),
        ([], [], False, np.nan, "no runs to compare"),
    ],
)
def test_what_the_seeds_cannot_tell_has_no_bounds(baseline, other, percent, estimate, note):
    found = analysis.paired_interval(baseline, other, percent=percent)
    assert found.estimate == pytest.approx(estimate, nan_ok=True)
    assert np.isnan([found.low, found.high]).all()
    assert (found.method, found.note) == ("none", note)


def test_intervals_say_where_they_may_be_too_narrow():
    five, ten = np.arange(1.0, 6), np.arange(1.0, 11)
    assert analysis.paired_interval(five, five**2).note == "few seeds: may be too narrow"
    assert analysis.paired_interval(ten, ten**2).note == ""
    ten[3] = 30  # a third of it: as if there were five seeds
    for percent in (False, True):
        note = analysis.paired_interval(ten, np.sqrt(ten), percent=percent).note
        assert note == "most of it in few seeds: may be too narrow"


def test_extreme_ratios_do_not_overflow():
    found = analysis.paired_interval([1, 1e9, 1], [1e9, 1, 1e9], percent=True, confidence=0.99999)
    assert (found.low, found.high) == (-100.0, np.inf)


def test_bad_arguments_are_refused():
    with pytest.raises(ValueError, match=r"shapes \(2,\), \(3,\)"):
        analysis.paired_interval([1, 2], [1, 2, 3])
    with pytest.raises(ValueError, match="confidence 95"):
        analysis.paired_interval([1, 2], [1, 2], confidence=95)
    with pytest.raises(ValueError, match=r"count 3 must be within 0\.\.2"):
        analysis.proportion(3, 2)
    with pytest.raises(ValueError, match="counts and exposures"):
        analysis.rate_ratio(count=1, exposure=-1.0, baseline_count=1, baseline_exposure=1.0)
    with pytest.raises(ValueError, match="relative 0"):
        analysis.events_needed(0.0)


def test_the_ratio_of_two_rates_has_statsmodels_score_interval():
    found = analysis.rate_ratio(count=7, exposure=2.0, baseline_count=10, baseline_exposure=1.0)
    assert found.ratio == pytest.approx(0.35)
    assert (found.low, found.high) == pytest.approx(confint_poisson_2indep(7, 2.0, 10, 1.0, method="score"), rel=1e-5)


def test_ratios_without_events():
    none = analysis.rate_ratio(count=0, exposure=1.0, baseline_count=10, baseline_exposure=1.0)
    # Wilson's upper bound of 0 of 10, as odds: z2 / 10.
    assert (none.ratio, none.low, none.high) == pytest.approx((0, 0, 1.959964**2 / 10), rel=1e-5)
    new = analysis.rate_ratio(count=10, exposure=1.0, baseline_count=0, baseline_exposure=1.0)
    assert (new.ratio, new.low, new.high) == pytest.approx((np.inf, 10 / 1.959964**2, np.inf), rel=1e-5)
    neither = analysis.rate_ratio(count=0, exposure=1.0, baseline_count=0, baseline_exposure=1.0)
    assert np.isnan(neither.ratio)
    assert (neither.low, neither.high) == (0, np.inf)
    assert np.isnan(analysis.rate_ratio(count=1, exposure=0.0, baseline_count=1, baseline_exposure=1.0).ratio)


def test_a_proportion_has_wilsons_interval():
    found = analysis.proportion(8, 10)
    assert (found.share, found.low, found.high) == pytest.approx((0.8, 0.49016, 0.94331), abs=1e-5)
    assert (analysis.proportion(0, 0).low, analysis.proportion(0, 0).high) == (0, 1)


def test_a_share_of_clusters_has_the_interval_of_fewer_events():
    """9, 8, 7 of 10: variance 3/2 * 2 / 30^2, so 48 events; by (1.96 / 4.30)^2 they are 9.96."""
    found = analysis.share_by_seed([9, 8, 7], [10, 10, 10])
    assert (found.low, found.high) == pytest.approx((44.309, 97.495), abs=0.001)
    alike = analysis.share_by_seed([10, 10, 0], [10, 10, 0])
    assert (alike.seeds, alike.high) == (2, 100.0)
    assert alike.low == pytest.approx(100 * np.sqrt(0.025)), "as much as two events can tell"
    apart = analysis.share_by_seed([10, 0, 10, 0], [10, 10, 10, 10])
    assert (apart.low < 5, apart.high > 95) == (True, True)
    assert np.isnan(analysis.share_by_seed([3], [4]).low)


def test_events_for_a_wanted_precision():
    assert analysis.events_needed(0.2) == 102
    rate = analysis.poisson_rate(102, 1.0)
    assert (rate.high - rate.low) / 2 / 102 == pytest.approx(relative_half_width(102, 0.95))
    assert relative_half_width(102, 0.95) <= 0.2 < relative_half_width(101, 0.95)


def test_the_rule_of_three():
    assert analysis.exposure_without_events(1e-3) == pytest.approx(3e3, rel=2e-3)


def test_seeds_for_a_wanted_half_width_of_a_difference():
    """Half-width of two seeds 1, so a spread of sqrt(2) / 12.7062: t / sqrt(n) has to fall to 0.5 / 0.1113."""
    now = SimpleNamespace(estimate=0.0, low=-1.0, high=1.0, seeds=2, method="t by seed")
    needed = analysis.seeds_needed(now, 0.5)
    half = [student.ppf(0.975, n - 1) / np.sqrt(n) * np.sqrt(2) / student.ppf(0.975, 1) for n in (needed, needed - 1)]
    assert half[0] <= 0.5 < half[1]


def test_seeds_that_are_said_to_be_needed_are_enough():
    rng = np.random.default_rng(3)

    def half_width(seeds, percent):
        level = rng.gamma(8, 1 / 8, seeds)
        found = analysis.paired_interval(rng.poisson(20 * level), rng.poisson(10 * level), percent=percent)
        return found, (found.high - found.low) / 2

    for percent, wanted in ((False, 2.0), (True, 8.0)):
        needed = np.median([analysis.seeds_needed(half_width(10, percent)[0], wanted) for _ in range(100)])
        assert needed > 12
        assert np.median([half_width(int(needed), percent)[1] for _ in range(100)]) == pytest.approx(wanted, rel=0.15)


def test_without_bounds_nothing_is_known_of_what_is_needed():
    assert np.isnan(analysis.seeds_needed(analysis.paired_interval([1], [2]), 1.0))
    with pytest.raises(ValueError, match="half_width"):
        analysis.seeds_needed(analysis.paired_interval([1, 3], [2, 1]), 0.0)
