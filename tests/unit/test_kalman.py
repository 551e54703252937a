import numpy as np
import pytest
from filterpy.kalman import KalmanFilter

from aeb_sumo.kalman import Gaussian, predict, update
from aeb_sumo.soa import put, take

N, STEPS, DT = 7, 60, 0.04
F = np.array([[1, DT, DT**2 / 2], [0, 1, DT], [0, 0, 1]])
Q = np.outer([DT**2 / 2, DT, 1], [DT**2 / 2, DT, 1]) * 0.3
R = np.array([0.04, 0.25])


def prior():
    rng = np.random.default_rng(3)
    root = rng.normal(size=(N, 3, 3))
    return Gaussian(rng.normal(size=(N, 3)), root @ root.transpose(0, 2, 1) + np.eye(3))


def filterpy_of(g, i):
    f = KalmanFilter(3, 2)
    f.x, f.P, f.F, f.Q, f.R, f.H = g.mean[i].copy(), g.cov[i].copy(), F, Q, np.diag(R), np.eye(3)[:2]
    return f


def test_equals_filterpy_with_masked_measurements():
    rng, g = np.random.default_rng(4), prior()
    filters = [filterpy_of(g, i) for i in range(N)]
    for _ in range(STEPS):
        z, use = rng.normal(size=(2, N)), rng.random(N) < 0.7
        g = predict(g, F, Q)
        for row, variance, measured in zip(np.eye(3)[:2], R, np.where(use, z, np.nan), strict=True):
            g = update(g, row, variance, measured, use)
        for f, measured, used in zip(filters, z.T, use, strict=True):
            f.predict()
            f.update(measured if used else None)
    np.testing.assert_allclose(g.mean, [f.x for f in filters], rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(g.cov, [f.P for f in filters], rtol=1e-10, atol=1e-12)


def test_rows_and_variances_of_each_vehicle_are_the_textbook_update():
    rng, g = np.random.default_rng(5), prior()
    rows, variances, z = rng.normal(size=(N, 3)), rng.random(N) + 0.1, rng.normal(size=N)
    out = update(g, rows, variances, z)
    for i in range(N):
        gain = g.cov[i] @ rows[i] / (rows[i] @ g.cov[i] @ rows[i] + variances[i])
        np.testing.assert_allclose(out.mean[i], g.mean[i] + gain * (z[i] - rows[i] @ g.mean[i]))
        np.testing.assert_allclose(out.cov[i], g.cov[i] - np.outer(gain, rows[i]) @ g.cov[i], atol=1e-12)


def test_process_noise_may_differ_between_vehicles():
    g, scale = prior(), np.arange(1.0, N + 1)
    out = predict(g, F, Q * scale[:, None, None])
    for i in range(N):
        np.testing.assert_allclose(out.cov[i], F @ g.cov[i] @ F.T + Q * scale[i])


def test_masked_vehicles_stay_as_they_are():
    g = prior()
    out = update(g, np.eye(3)[0], 0.1, np.full(N, np.nan), np.zeros(N, bool))
    np.testing.assert_array_equal(out.mean, g.mean)
    np.testing.assert_array_equal(out.cov, g.cov)


def test_inputs_are_not_changed_and_covariances_stay_symmetric():
    g = predict(prior(), np.eye(3), np.zeros((3, 3)))
    mean, cov = g.mean.copy(), g.cov.copy()
    out = update(predict(g, F, Q), np.array([1.0, 0.3, 0.0]), 0.1, np.ones(N))
    np.testing.assert_array_equal(g.mean, mean)
    np.testing.assert_array_equal(g.cov, cov)
    np.testing.assert_allclose(out.cov, out.cov.transpose(0, 2, 1), rtol=1e-13)


@pytest.mark.parametrize("rows", [np.array([4, 0]), np.arange(N) > 3])
def test_vehicles_can_be_taken_out_and_put_back(rows):
    g = predict(prior(), F, Q)
    one = update(predict(take(g, rows), F, Q), np.eye(3)[0], 0.1, np.ones(len(take(g, rows).mean)))
    everyone = update(predict(g, F, Q), np.eye(3)[0], 0.1, np.ones(N))
    put(g, rows, one)
    np.testing.assert_allclose(g.cov[rows], everyone.cov[rows], rtol=1e-12)
    np.testing.assert_allclose(g.mean[rows], everyone.mean[rows], rtol=1e-12)
