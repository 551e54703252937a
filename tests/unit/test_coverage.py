"""95 % intervals cover what they should in 93 to 97 % of worlds, by enumeration or simulation."""

import numpy as np
import pytest
from scipy.stats import binom, poisson

import analysis

WORLDS = 1000


def counts(mean):
    return np.arange(int(mean + 8 * np.sqrt(mean) + 12))


def covered(intervals, truth):
    """Share of intervals that hold the truth, and of those that have bounds at all."""
    known = [i for i in intervals if not np.isnan(i.low)]
    return np.mean([i.low <= truth <= i.high for i in known]), len(known) / len(intervals)


@pytest.mark.parametrize("mean", [20, 50, 100, 300])
def test_poisson_rates(mean):
    rates = [analysis.poisson_rate(int(k), 2.0) for k in counts(mean)]
    share = sum(poisson.pmf(k, mean) * (r.low <= mean / 2 <= r.high) for k, r in zip(counts(mean), rates, strict=True))
    assert 0.93 <= share <= 0.97


@pytest.mark.parametrize("mean", [0.1, 0.5, 1, 2, 3, 5, 8, 10])
def test_poisson_rates_of_few_events_are_cautious(mean):
    rates = [analysis.poisson_rate(int(k), 1.0) for k in counts(mean)]
    share = sum(poisson.pmf(k, mean) * (r.low <= mean <= r.high) for k, r in zip(counts(mean), rates, strict=True))
    assert 0.95 <= share <= 1.0


@pytest.mark.parametrize(("mean", "ratio"), [(5, 0.2), (10, 1.0), (10, 0.5), (20, 0.5), (20, 0.1), (30, 0.3)])
def test_rate_ratios(mean, ratio):
    share = 0.0
    for base in counts(mean):
        for count in counts(mean * ratio):
            found = analysis.rate_ratio(count=int(count), exposure=3.0, baseline_count=int(base), baseline_exposure=3.0)
            weight = poisson.pmf(base, mean) * poisson.pmf(count, mean * ratio)
            share += weight * (found.low <= ratio <= found.high)
    assert 0.93 <= share <= 0.97


@pytest.mark.parametrize("trials", [10, 20, 50, 200])
def test_proportions_on_average_over_shares(trials):
    found = [analysis.proportion(k, trials) for k in range(trials + 1)]
    low, high = np.array([f.low for f in found]), np.array([f.high for f in found])
    shares = np.linspace(0.02, 0.98, 97)[:, None]
    each = np.sum(binom.pmf(np.arange(trials + 1), trials, shares) * ((low <= shares) & (shares <= high)), axis=1)
    assert 0.93 <= each.mean() <= 0.97
    assert each.min() > 0.89, "near 0 and 1"
    assert np.mean((each >= 0.93) & (each <= 0.97)) >= {10: 0.55, 20: 0.7, 50: 0.9, 200: 0.99}[trials]


def even(rng, seeds):
    """A figure such as delay: the seeds differ, the AEB changes it by 0.6 of 8, more in some."""
    level = 8 + rng.normal(0, 2, (WORLDS, seeds))
    return level + rng.normal(0, 0.5, level.shape), level + 0.6 + rng.normal(0, 0.7, level.shape)


def clusters(rng, seeds):
    """Crashes whose rate differs much between the seeds: 20 on average, 6 with AEB."""
    level = rng.gamma(2, 0.5, (WORLDS, seeds))
    return rng.poisson(20 * level), rng.poisson(6 * level)


def few(rng, seeds):
    """Two crashes per seed, one with AEB."""
    return rng.poisson(2.0, (WORLDS, seeds)), rng.poisson(1.0, (WORLDS, seeds))


def pile_ups(rng, seeds, *, per_seed=4.0, size=5.0, left=0.4):
    """Pile-ups of geometric size, of which some are left with AEB."""
    number = np.minimum(rng.poisson(per_seed, (WORLDS, seeds)), 16)
    there = np.arange(16) < number[..., None]
    crashes = rng.geometric(1 / size, there.shape) * there
    return crashes.sum(axis=-1), (crashes * (rng.random(there.shape) < left)).sum(axis=-1)


def severity(rng, seeds):
    """Expected seriously injured: risks of 0.05 on average, per crash of `pile_ups` size 2; half as large with AEB."""
    crashes, left = pile_ups(rng, seeds, per_seed=4.0, size=2.0, left=0.5)
    # A sum of k risks, each beta(0.5, 9.5), is near a gamma of the same mean and variance.
    return rng.gamma(0.55 * crashes + 1e-9, 0.0909), rng.gamma(0.55 * left + 1e-9, 0.0909 * 0.5)


def both(world, seeds):
    return zip(*world(np.random.default_rng(seeds), seeds), strict=True)


TRUTH = {even: (8.0, 8.6), clusters: (20.0, 6.0), few: (2.0, 1.0), pile_ups: (20.0, 8.0)}
TRUTH[severity] = (8 * 0.55 * 0.0909, 8 * 0.55 * 0.0909 * 0.25)


@pytest.mark.parametrize("seeds", [4, 6, 20])
@pytest.mark.parametrize("world", list(TRUTH))
@pytest.mark.parametrize("percent", [False, True])
def test_what_changes_by_seed(world, seeds, percent):
    before, after = TRUTH[world]
    truth = 100 * (after / before - 1) if percent else after - before
    found = [analysis.paired_interval(b, a, percent=percent) for b, a in both(world, seeds)]
    share, known = covered(found, truth)
    assert known > 0.97
    # Where some seeds have no crash at all, few of them are cautious.
    assert 0.93 <= share <= (0.985 if world is few and seeds < 10 else 0.97)


@pytest.mark.parametrize("world", [even, clusters])
def test_differences_of_three_seeds_are_marked(world):
    found = [analysis.paired_interval(b, a) for b, a in both(world, 3)]
    assert 0.91 <= covered(found, TRUTH[world][1] - TRUTH[world][0])[0] <= 0.97
    assert {i.note for i in found} == {"few seeds: may be too narrow"}


def test_rare_pile_ups_are_beyond_ten_seeds_and_marked():
    """Where 0.7 pile-ups a seed make up all the crashes."""
    worlds = pile_ups(np.random.default_rng(1), 10, per_seed=0.7, size=8.0)
    found = [analysis.paired_interval(b, a, percent=True) for b, a in zip(*worlds, strict=True)]
    assert 0.80 < covered(found, -60)[0] < 0.93
    assert np.mean([i.note != "" for i in found]) > 0.95


@pytest.mark.parametrize("seeds", [3, 5, 20])
def test_shares_of_clusters(seeds):
    """Pile-ups of which each is avoided by a share of its own, 0.8 on average."""
    rng = np.random.default_rng(seeds)
    there = np.arange(16) < np.minimum(rng.poisson(4, (WORLDS, seeds)), 16)[..., None]
    crashes = rng.geometric(0.25, there.shape) * there
    avoided = rng.binomial(crashes, rng.beta(0.8, 0.2, there.shape))
    totals = zip(avoided.sum(axis=-1), crashes.sum(axis=-1), strict=True)
    share, known = covered([analysis.share_by_seed(x, m) for x, m in totals], 80)
    assert known > 0.97
    assert 0.93 <= share <= (0.985 if seeds == 3 else 0.97)


def test_shares_of_independent_events_are_cautious():
    rng = np.random.default_rng(4)
    crashes = rng.poisson(5, (WORLDS, 10))
    avoided = rng.binomial(crashes, 0.8)
    share, _ = covered([analysis.share_by_seed(x, m) for x, m in zip(avoided, crashes, strict=True)], 80)
    assert 0.97 <= share <= 1.0
