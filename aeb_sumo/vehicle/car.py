"""The three-degree-of-freedom car of Lin et al. 2021, eqs. 1-3 and 8-13, on four wheels that spin.

ISO axes: x forward, y to the left, yaw to the left. Wheels are front left, front right, rear left, rear right. In these
axes the left wheels take the lower sign of the printed `+-` in eqs. 8, 12 and 13. With a wheel at `(x, y)` in the car
the equations of all four are the same, and they are written so.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from aeb_sumo.parameters import check
from aeb_sumo.soa import Floats
from aeb_sumo.units import G
from aeb_sumo.vehicle.tyre import Tyre, adhesion, tyre_forces

__all__ = ["MIN_SPEED", "Car", "CarState", "car_init", "car_step", "normalised_forces", "wheel_loads"]

MIN_SPEED = 0.5
"""Below this speed [m/s] slips are those at this speed, our assumption: they are singular at standstill."""


@dataclass(frozen=True, kw_only=True)
class Car:
    """A mid-size saloon. The source gives no vehicle data: every default is our assumption.

    Attributes:
        mass: [kg], our assumption.
        yaw_inertia: [kg m2], our assumption.
        a, b: from the centre of gravity to the front and the rear axle [m], our assumption.
        track_front, track_rear: [m], our assumption.
        cog_height: of the centre of gravity [m], our assumption.
        wheel_radius: [m], our assumption.
        wheel_inertia: of one wheel [kg m2], our assumption.
        substep: largest step of the integration [s], our assumption.
    """

    mass: float = 1500.0
    yaw_inertia: float = 2500.0
    a: float = 1.2
    b: float = 1.5
    track_front: float = 1.55
    track_rear: float = 1.55
    cog_height: float = 0.54
    wheel_radius: float = 0.31
    wheel_inertia: float = 1.0
    substep: float = 0.001

    def __post_init__(self) -> None:
        """Raises `InputError` for a parameter out of range."""
        check(self, positive=True)

    @property
    def x(self) -> Floats:
        """(4,) wheels ahead of the centre of gravity [m]."""
        return np.array([self.a, self.a, -self.b, -self.b])

    @property
    def y(self) -> Floats:
        """(4,) wheels to the left of the centre of gravity [m]."""
        return np.array([self.track_front, -self.track_front, self.track_rear, -self.track_rear]) / 2


@dataclass(frozen=True)
class CarState:
    """Motion, one row per car.

    The wheels' speeds are the state and not their slips, which follow by eq. 9 and have no meaning at standstill.

    Attributes:
        speed_x, speed_y: (n,) velocity of the centre of gravity [m/s]; the car does not go backwards.
        yaw_rate: (n,) [rad/s].
        spin: (n, 4) angular speed of the wheels, >= 0 [rad/s].
        accel_x, accel_y: (n,) what an accelerometer at the centre of gravity shows, eq. 14 [m/s2].
        yaw_accel: (n,) [rad/s2].
    """

    speed_x: Floats
    speed_y: Floats
    yaw_rate: Floats
    spin: Floats
    accel_x: Floats
    accel_y: Floats
    yaw_accel: Floats


def car_init(car: Car, speed: Floats) -> CarState:
    """Cars that roll straight ahead at `speed`, (n,) [m/s]."""
    spin = np.repeat(speed[:, None] / car.wheel_radius, 4, axis=1)
    vy, r, ax, ay, yaw = np.zeros((5, len(speed)))
    return CarState(speed.copy(), vy, r, spin, ax, ay, yaw)


def wheel_loads(car: Car, *, accel_x: Floats, accel_y: ArrayLike) -> Floats:
    """(n, 4) vertical forces of the wheels [N], eq. 8, none below zero.

    Args:
        car: parameters.
        accel_x: (n,) forward acceleration [m/s2].
        accel_y: (n,) acceleration to the left [m/s2], which relieves the left wheels.
    """
    x, y, base = car.x, car.y, car.a + car.b
    lift = np.asarray(accel_y)[..., None] * car.cog_height / (2 * y)
    share = 1 - np.abs(x) / base  # of the axle
    pitch = accel_x[:, None] * car.cog_height / (2 * base) * np.sign(x)
    loads: Floats = np.maximum(car.mass * ((G / 2 - lift) * share - pitch), 0.0)
    return loads


def _wheel_motion(car: Car, state: CarState, steer: Floats) -> tuple[Floats, Floats, Floats]:
    """(n, 4) speed of the wheels [m/s], eqs. 10-12, their slip, eq. 9, and tangent of slip angle, eq. 13.

    Eq. 12 is printed with the other sign before beta, which turns the front wheels the wrong way; eq. 9 is printed
    traction-positive.
    """
    vx, vy, r = state.speed_x[:, None], state.speed_y[:, None], state.yaw_rate[:, None]
    beta = np.arctan2(vy, np.maximum(vx, MIN_SPEED))
    speed = np.maximum(np.hypot(vx, vy) + r * (car.x * beta - car.y), 0.0)
    slip = np.minimum((speed - state.spin * car.wheel_radius) / np.maximum(speed, MIN_SPEED), 1.0)
    drift = np.arctan2(vy + car.x * r, np.maximum(vx - car.y * r, MIN_SPEED))
    return speed, slip, np.tan(_wheel_angle(steer) - drift)


def _wheel_angle(steer: Floats) -> Floats:
    """(n, 4) steering angle of every wheel [rad]."""
    angle: Floats = steer[:, None] * np.array([1.0, 1.0, 0.0, 0.0])
    return angle


def normalised_forces(car: Car, tyre: Tyre, state: CarState, *, steer: Floats) -> tuple[Floats, Floats]:
    """(n, 4) `Fx0` and `Fy0` [N], in the axes of the wheels, from what an on-board estimator can measure."""
    _, slip, tan_alpha = _wheel_motion(car, state, steer)
    load = wheel_loads(car, accel_x=state.accel_x, accel_y=state.accel_y)
    return tyre_forces(tyre, slip=slip, tan_alpha=tan_alpha, load=load, speed=state.speed_x[:, None])


def car_step(
    car: Car, tyre: Tyre, state: CarState, *, steer: Floats, brake_torque: Floats, mu: Floats, dt: float
) -> CarState:
    """Move for one step with constant inputs.

    Args:
        car: parameters.
        tyre: parameters of all four tyres.
        state: (n,) motion.
        steer: (n,) angle of the front wheels, positive to the left [rad].
        brake_torque: (n, 4) at the wheels [N m]; negative drives. Brakes stop a wheel and do not turn it back.
        mu: (n, 4) friction coefficient under each wheel.
        dt: step [s].
    """
    substeps = max(1, round(dt / car.substep))
    for _ in range(substeps):
        state = _substep(car, tyre, state, steer, brake_torque, mu, dt / substeps)
    return state


def _substep(
    car: Car, tyre: Tyre, state: CarState, steer: Floats, brake_torque: Floats, mu: Floats, h: float
) -> CarState:
    _, slip, tan_alpha = _wheel_motion(car, state, steer)
    load = wheel_loads(car, accel_x=state.accel_x, accel_y=state.accel_y)
    grip = mu * load * adhesion(tyre, slip=slip, tan_alpha=tan_alpha, speed=state.speed_x[:, None])
    force_x, force_y = -tyre.c_x * slip * grip, tyre.c_y * tan_alpha * grip
    angle = _wheel_angle(steer)
    forward = force_x * np.cos(angle) - force_y * np.sin(angle)
    left = force_x * np.sin(angle) + force_y * np.cos(angle)
    # Eqs. 1-3; the moment of the rear axle in eq. 3 is printed with Fy of the front left wheel instead of the rear.
    accel_x, accel_y = forward.sum(axis=1) / car.mass, left.sum(axis=1) / car.mass
    yaw_accel = (car.x * left - car.y * forward).sum(axis=1) / car.yaw_inertia
    state = CarState(
        np.maximum(state.speed_x + h * (accel_x + state.yaw_rate * state.speed_y), 0.0),
        state.speed_y + h * (accel_y - state.yaw_rate * state.speed_x),
        state.yaw_rate + h * yaw_accel,
        state.spin,
        accel_x,
        accel_y,
        yaw_accel,
    )
    # The slip of the wheels is very stiff at low speed, so their new spin takes the secant stiffness of the tyre with
    # the new slip: stable for any step, exact once it has settled.
    speed, _, _ = _wheel_motion(car, state, steer)
    stiffness = tyre.c_x * grip * car.wheel_radius / np.maximum(speed, MIN_SPEED)  # [N m per m/s of slip]
    spin = state.spin + h * (stiffness * (speed - car.wheel_radius * state.spin) - brake_torque) / (
        car.wheel_inertia + h * stiffness * car.wheel_radius
    )
    return replace(state, spin=np.maximum(spin, 0.0))
