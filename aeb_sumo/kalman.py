"""Kalman filter steps for fleets: one Gaussian per vehicle, whole arrays at a time.

filterpy filters one vehicle per object; these are its equations for `n` vehicles at once, and the tests hold them to
filterpy within rounding. The arrays that come out are laid out with the vehicle as the fastest axis in memory, which
makes numpy's loops long; arrays laid out otherwise are taken as well.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from aeb_sumo.soa import Bools, Floats

__all__ = ["Gaussian", "predict", "update"]


@dataclass(frozen=True)
class Gaussian:
    """What is believed of `k` quantities of each of `n` vehicles.

    Attributes:
        mean: (n, k) expected values.
        cov: (n, k, k) covariances, symmetric.
    """

    mean: Floats
    cov: Floats


def predict(g: Gaussian, transition: Floats, process: Floats) -> Gaussian:
    """One step of time: `x = F x`, `P = F P F' + Q`.

    Args:
        g: what is believed before.
        transition: (k, k) F, the same for all.
        process: (k, k) or (n, k, k) Q, the covariance that the step adds.
    """
    n, k = g.mean.shape
    mean = (transition @ g.mean.T).T
    # F P F' is linear in P, so one product of a (k k, k k) with a (k k, n) matrix does it for all vehicles.
    cov = np.kron(transition, transition) @ g.cov.transpose(1, 2, 0).reshape(k * k, n)
    cov = cov.reshape(k, k, n).transpose(2, 0, 1)
    cov += process
    return Gaussian(mean, cov)


def update(g: Gaussian, row: Floats, variance: ArrayLike, measured: Floats, use: Bools | None = None) -> Gaussian:
    """Learn one scalar per vehicle, `z = h x + noise`.

    Independent scalars, one after another, do what their joint update does.

    Args:
        g: what is believed before.
        row: (k,) or (n, k) h.
        variance: of the noise, scalar or (n,), > 0.
        measured: (n,) z.
        use: (n,) which vehicles have the measurement, the others stay as they are; None for all.
    """
    if use is not None:  # infinite noise teaches nothing
        measured, variance = np.where(use, measured, 0.0), np.where(use, variance, np.inf)
    row = np.broadcast_to(row, g.mean.shape)
    across = np.einsum("nij,nj->ni", g.cov, row)
    sigma = np.sqrt(np.einsum("ni,ni->n", row, across) + variance)
    surprise = (measured - np.einsum("ni,ni->n", row, g.mean)) / sigma
    gain = across / sigma[:, None]  # in units of sigma: its outer product is symmetric to the last bit
    learned = gain[:, :, None] * gain[:, None, :]
    return Gaussian(g.mean + gain * surprise[:, None], np.subtract(g.cov, learned, out=learned))
