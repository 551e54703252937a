"""Reaction models against the published parameters."""

import numpy as np
import pytest

from aeb_sumo.drivers.reactions import MODELS, Careful, Looming, Threat, Zheng, trucks
from aeb_sumo.drivers.streams import stream
from aeb_sumo.units import G

N = 4000


def responses(model, **threat):
    what = Threat(**({"time_to_crash": 2.0, "closing_speed": 10.0, "late": False} | threat))
    return [model.respond(stream(1, "driver", str(k)), stream(1, "encounter", str(k)), what) for k in range(N)]


@pytest.mark.parametrize(
    ("model", "mean", "sd", "decel", "decel_sd"),
    [(Looming(), 0.22, 0.29, 6.68, 1.69), (trucks(), 0.27, 0.40, 4.70, 1.44)],
    ids=["Markkula-2016-cars", "Markkula-2016-trucks"],
)
def test_eyes_on_the_threat(model, mean, sd, decel, decel_sd):
    """alpha is normal: quantiles above 0, where it is not cut off."""
    drawn = responses(model)
    alpha = np.array([r.delay for r in drawn]) / 2.0
    for z in (0.0, 0.5, 1.0):
        assert np.quantile(alpha, 0.5 + 0.5 * _within(z)) == pytest.approx(mean + z * sd, abs=0.03)
    reached = np.array([r.decel for r in drawn])
    assert reached.mean() == pytest.approx(decel, abs=0.1)
    assert reached.std() == pytest.approx(decel_sd, abs=0.12)


def _within(z):
    from scipy.stats import norm

    return 2 * norm.cdf(z) - 1


@pytest.mark.parametrize(
    ("model", "mu", "sigma"), [(Looming(), -1.40, 0.71), (trucks(), -0.51, 0.85)], ids=["Markkula-cars", "-trucks"]
)
def test_eyes_that_come_back_late(model, mu, sigma):
    delay = np.array([r.delay for r in responses(model, late=True)])
    braking = np.isfinite(delay)
    assert np.median(delay) == pytest.approx(2.0 * np.exp(mu), rel=0.05)
    from scipy.stats import norm

    assert 1 - braking.mean() == pytest.approx(norm.sf(-mu / sigma), abs=0.02), "alpha of 1 or more: no braking"


def test_jerk_grows_with_the_looming_at_the_onset():
    """9.82 k, with the median of k at exp(1.23)."""
    gain = [r.jerk_per_looming for r in responses(Looming())]
    assert np.median(gain) == pytest.approx(9.82 * np.exp(1.23), rel=0.05)


def test_delay_is_a_share_of_the_time_to_the_crash():
    near, far = responses(Looming(), time_to_crash=1.0), responses(Looming(), time_to_crash=3.0)
    for a, b in zip(near[:50], far[:50], strict=True):
        if np.isfinite(a.delay):
            assert b.delay == pytest.approx(3 * a.delay)


def test_the_careful_driver_is_that_of_un_r157():
    (first, second) = responses(Careful())[:2]
    assert first == second
    assert (first.delay, first.decel, first.jerk) == (0.75, 0.774 * G, 12.65)
    assert 1 / Careful().looming == 2.0


def test_drivers_of_zheng_have_one_of_four_classes_for_good():
    slow, fast = responses(Zheng(), closing_speed=5.0), responses(Zheng(), closing_speed=5.0, late=True)
    assert [r.delay for r in slow] == [r.delay for r in fast]
    times, counts = np.unique([r.delay for r in slow], return_counts=True)
    assert len(times) == 4
    assert counts / N == pytest.approx(np.full(4, 0.25), abs=0.03)


@pytest.mark.parametrize("model", [*(m() for m in MODELS.values()), trucks()])
def test_laws(model):
    for late in (False, True):
        for r in responses(model, late=late)[:300]:
            assert r.delay >= 0
            assert r.decel > 0
            assert r.jerk + r.jerk_per_looming > 0
