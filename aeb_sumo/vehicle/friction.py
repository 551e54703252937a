"""Road friction from the car's own motion: the extended Kalman filter of Lin et al. 2021, eqs. 14-17.

The state is mu of the four wheels, a random walk; acceleration forward, to the left and in yaw are linear in it once
slips and loads have given the normalised forces. Three deviations make it work (shared/seeds.md A18):

* the third measurement is yaw *acceleration*; the source lists the yaw rate and differentiates the acceleration;
* running straight, the three measurements see 2 of the 4 states. Two pseudo-measurements say that the wheels of one
  side stand on the same road;
* nothing is learned without force at the wheels: cruising, the estimate stays and its variance grows.
"""

from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from aeb_sumo.kalman import Gaussian, predict, update
from aeb_sumo.parameters import check
from aeb_sumo.soa import Bools, Floats
from aeb_sumo.units import G
from aeb_sumo.vehicle.car import MIN_SPEED, Car, wheel_loads
from aeb_sumo.vehicle.tyre import Tyre, slip_for, tyre_forces

__all__ = [
    "BOUNDS",
    "TIE",
    "FrictionParams",
    "friction_estimate",
    "friction_init",
    "friction_step",
    "informative",
    "jacobian",
    "reference_filter",
    "straight_forces",
]

TIE = np.array([[1.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, -1.0]])
"""Rows of the pseudo-measurements: front minus rear, left and right, is zero."""

BOUNDS = 0.05, 1.2
"""What an estimate is kept within [-], our assumption."""


@dataclass(frozen=True, kw_only=True)
class FrictionParams:
    """The estimator; the source gives no numbers.

    The noises are given for steps of `period` and hold for any other: process noise grows with the step, measurement
    noise falls with it, as that of a sensor averaged over the step.

    Attributes:
        car: what the estimator believes of its car.
        period: step that the noises belong to [s], our assumption.
        walk: standard deviation of the change of mu per step of `period`; 0.01 is Q = 1e-4 I, our assumption.
        sigma_accel: noise of both accelerations [m/s2], our assumption.
        sigma_yaw: noise of the yaw acceleration [rad/s2], our assumption.
        sigma_tie: how much the wheels of one side may differ, our assumption.
        sigma_prior: of mu at the start, our assumption.
        gate: sum of |Fx0| over weight from which the measurements are used, our assumption.
    """

    car: Car = field(default_factory=Car)
    period: float = 0.01
    walk: float = 0.01
    sigma_accel: float = 0.05
    sigma_yaw: float = 0.02
    sigma_tie: float = 0.02
    sigma_prior: float = 0.2
    gate: float = 0.02

    def __post_init__(self) -> None:
        """Raises `InputError` for a parameter out of range."""
        check(self, positive=True)

    def process(self, dt: float) -> Floats:
        """(4, 4) covariance that a step of `dt` [s] adds."""
        return np.eye(4) * self.walk**2 * dt / self.period

    def variances(self, dt: float) -> Floats:
        """(5,) of the three measurements and the two ties, for a step of `dt` [s]."""
        sigmas = [self.sigma_accel, self.sigma_accel, self.sigma_yaw, self.sigma_tie, self.sigma_tie]
        return np.square(sigmas) * self.period / dt


def friction_init(params: FrictionParams, n: int, mu: ArrayLike) -> Gaussian:
    """(n, 4) estimates that start from `mu`, a scalar or (n,)."""
    mean = np.empty((n, 4))
    mean[:] = np.reshape(mu, (-1, 1))
    return Gaussian(mean, np.tile(np.eye(4) * params.sigma_prior**2, (n, 1, 1)))


def jacobian(car: Car, *, force_x: Floats, force_y: Floats, steer: Floats) -> Floats:
    """(n, 3, 4) derivatives of forward, left and yaw acceleration by mu of the wheels, eq. 17 for small angles.

    Corrected as eqs. 1-3 demand: the left row has `Fx0 delta` where `Fy0 delta` is printed; in the yaw row the print
    has `-b Fy0` of the right front wheel, which does not belong there, and lacks that of the left rear wheel.

    Args:
        car: parameters.
        force_x: (n, 4) normalised forces, forward in the axes of the wheels [N].
        force_y: (n, 4) the same to the left [N].
        steer: (n,) angle of the front wheels [rad].
    """
    rows = np.empty((3, 4, len(steer)))  # vehicles last in memory: see `kalman`
    forward, left, yaw = rows
    forward[:], left[:] = force_x.T, force_y.T
    forward[:2] -= force_y.T[:2] * steer
    left[:2] += force_x.T[:2] * steer
    yaw[:] = (car.x[:, None] * left - car.y[:, None] * forward) / car.yaw_inertia
    rows[:2] /= car.mass
    return rows.transpose(2, 0, 1)


def informative(params: FrictionParams, force_x: Floats) -> Bools:
    """(n,) whether (n, 4) normalised forces [N] are large enough to tell friction."""
    use: Bools = np.abs(force_x).sum(axis=1) > params.gate * params.car.mass * G
    return use


def friction_step(
    params: FrictionParams,
    state: Gaussian,
    *,
    force_x: Floats,
    force_y: Floats,
    steer: Floats,
    accel_x: Floats,
    accel_y: Floats,
    yaw_accel: Floats,
    dt: float,
) -> Gaussian:
    """One step of the filter.

    Args:
        params: the estimator.
        state: (n, 4) estimates.
        force_x: (n, 4) normalised forces, forward in the axes of the wheels [N].
        force_y: (n, 4) the same to the left [N].
        steer: (n,) angle of the front wheels, positive to the left [rad].
        accel_x: (n,) measured acceleration, forward [m/s2].
        accel_y: (n,) the same to the left [m/s2].
        yaw_accel: (n,) measured yaw acceleration, positive to the left [rad/s2].
        dt: step [s].
    """
    state = predict(state, np.eye(4), params.process(dt))
    rows = jacobian(params.car, force_x=force_x, force_y=force_y, steer=steer)
    use, variances = informative(params, force_x), params.variances(dt)
    for i, measured in enumerate((accel_x, accel_y, yaw_accel)):
        state = update(state, rows[:, i], variances[i], measured, use)
    for row, variance in zip(TIE, variances[3:], strict=True):
        state = update(state, row, variance, np.zeros_like(accel_x))
    return state


def friction_estimate(state: Gaussian) -> Floats:
    """(n,) friction of the road under the car: the mean of the four wheels, within `BOUNDS`."""
    estimate: Floats = np.clip(state.mean.mean(axis=1), *BOUNDS)
    return estimate


def straight_forces(car: Car, tyre: Tyre, *, accel: Floats, speed: Floats, mu: Floats) -> Floats:
    """(n, 4) `Fx0` [N] that an on-board estimator works out of the wheel slips of a car that runs straight ahead.

    For traffic, where only speed and acceleration are known: the slips are those that bring `accel` about on the true
    friction, quasi-statically, with every wheel sharing the force by its load. At the peak of the tyre the slip
    saturates, and the normalised force with it, at the load.

    Args:
        car: parameters.
        tyre: parameters.
        accel: (n,) true acceleration, negative in braking [m/s2].
        speed: (n,) [m/s]; below `MIN_SPEED` slip cannot be measured and the forces are zero.
        mu: (n,) true friction coefficient.
    """
    slip = np.where(speed < MIN_SPEED, 0.0, slip_for(tyre, ratio=accel / (mu * G), speed=speed))
    load = wheel_loads(car, accel_x=accel, accel_y=0.0)
    return tyre_forces(tyre, slip=slip[:, None], tan_alpha=0.0, load=load, speed=speed[:, None])[0]


def reference_filter(params: FrictionParams, mu: float, dt: float) -> Any:
    """The same filter for one vehicle by filterpy, an `ExtendedKalmanFilter`, which the tests compare with.

    A step is `predict()` and `update(z, HJacobian, Hx)` with the three rows of `jacobian` and the two of `TIE`.
    """
    kalman = import_module("filterpy.kalman")  # takes a second, and only tests need it
    reference = kalman.ExtendedKalmanFilter(dim_x=4, dim_z=5)
    reference.x = np.full(4, mu)
    reference.P = np.eye(4) * params.sigma_prior**2
    reference.F = np.eye(4)
    reference.Q = params.process(dt)
    reference.R = np.diag(params.variances(dt))
    return reference
