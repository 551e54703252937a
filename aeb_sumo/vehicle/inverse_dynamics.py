"""The inverse vehicle dynamics of Zhao et al. 2025, 2.3: from acceleration to throttle, from deceleration to pressure.

The source turns the controlled acceleration into the pedals of a CarSim F-class sedan, whose data it does not print;
`Sedan` stands in for it. The car moves forwards on a level road: rolling resistance always brakes.
"""

from dataclasses import dataclass

import numpy as np

from aeb_sumo.soa import Floats, Ints
from aeb_sumo.units import G

__all__ = [
    "Sedan",
    "acceleration_of",
    "deceleration_of",
    "drive_force",
    "engine_torque",
    "gear_of",
    "pressure_of",
    "throttle_of",
]


@dataclass(frozen=True, kw_only=True)
class Sedan:
    """A large sedan with a torque converter and an automatic gearbox.

    Attributes:
        mass: m [kg], our assumption.
        drag_area: C_D A [m2], our assumption.
        air_density: rho [kg/m3], our assumption.
        rolling: coefficient of rolling resistance f, our assumption.
        rotating: delta, rotating masses as a factor on the mass, our assumption; the same in all gears.
        wheel_radius: r [m], our assumption.
        gears: i_g, first gear first, our assumption.
        final_drive: i_0, our assumption.
        upshift: speeds from which the next gear is used [m/s], one less than gears, our assumption.
        efficiency: eta_T, our assumption.
        stall_ratio: phi, torque ratio of the converter, at standstill, our assumption; from there it falls linearly
            to 1 at `coupling`.
        coupling: ratio of turbine to engine speed from which the converter only couples, our assumption.
        launch: speed that the engine keeps while the turbine is slower [rad/s], our assumption.
        map_speed: (s,) engine speeds of the map [rad/s], rising, our assumption.
        map_throttle: (t,) throttle openings of the map, 0 to 1, rising, our assumption.
        full_torque: (s,) torque with the throttle open [N m], our assumption.
        closed_torque: (s,) torque with the throttle closed, < 0: the engine brakes [N m], our assumption.
        opening: (t,) share of the way from closed to full torque, 0 to 1, rising, our assumption; the same at
            every speed, which makes the inverse of the map exact.
        force_per_pressure: K_b, brake force by master-cylinder pressure [N/Pa]: 3097.26, printed (2.3) without unit,
            N/MPa by its magnitude (10 m/s2 need 6 MPa).
    """

    mass: float = 1820.0
    drag_area: float = 0.75
    air_density: float = 1.206
    rolling: float = 0.012
    rotating: float = 1.05
    wheel_radius: float = 0.34
    gears: tuple[float, ...] = (4.17, 2.34, 1.52, 1.14, 0.87, 0.69)
    final_drive: float = 3.3
    upshift: tuple[float, ...] = (6.0, 11.0, 17.0, 23.0, 30.0)
    efficiency: float = 0.9
    stall_ratio: float = 2.0
    coupling: float = 0.9
    launch: float = 150.0
    map_speed: tuple[float, ...] = (80.0, 150.0, 250.0, 350.0, 450.0, 550.0, 650.0)
    map_throttle: tuple[float, ...] = (0.0, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0)
    full_torque: tuple[float, ...] = (250.0, 330.0, 380.0, 400.0, 400.0, 370.0, 310.0)
    closed_torque: tuple[float, ...] = (-20.0, -25.0, -35.0, -45.0, -55.0, -65.0, -75.0)
    opening: tuple[float, ...] = (0.0, 0.25, 0.45, 0.65, 0.8, 0.93, 1.0)
    force_per_pressure: float = 3097.26e-6


def _resistance(car: Sedan, speed: Floats) -> Floats:
    """Air and rolling resistance at `speed` [m/s], >= 0 [N]."""
    return 0.5 * car.drag_area * car.air_density * speed**2 + car.mass * G * car.rolling


def drive_force(car: Sedan, *, accel: Floats, speed: Floats) -> Floats:
    """`F_t = C_D A rho v^2 / 2 + m g f + delta m a` (eq. 8) [N], < 0 where the resistances brake too little.

    Args:
        car: the car.
        accel: (n,) acceleration, signed [m/s2].
        speed: (n,) [m/s].
    """
    return _resistance(car, speed) + car.rotating * car.mass * accel


def gear_of(car: Sedan, speed: Floats) -> Ints:
    """(n,) gear at `speed` [m/s], 0 for the first."""
    return np.searchsorted(car.upshift, speed, side="right")


def _transmission(car: Sedan, speed: Floats) -> tuple[Floats, Floats]:
    """(n,) engine speed [rad/s], and force at the wheels by torque of the engine `i_g i_0 eta_T phi / r` [1/m].

    The source does not say what n0 and n_c in `phi(n0 / n_c)` are; here they are the turbine's and the engine's speed.
    """
    ratio = np.asarray(car.gears)[gear_of(car, speed)] * car.final_drive
    turbine = speed / car.wheel_radius * ratio
    engine = np.maximum(turbine, car.launch)
    phi = np.interp(turbine / engine, [0.0, car.coupling], [car.stall_ratio, 1.0])
    return engine, ratio * car.efficiency * phi / car.wheel_radius


def engine_torque(car: Sedan, *, accel: Floats, speed: Floats) -> Floats:
    """`T_q = F_t r / (i_g i_0 eta_T phi)` (eq. 9), (n,) [N m]; arguments as for `drive_force`."""
    _, force_per_torque = _transmission(car, speed)
    return drive_force(car, accel=accel, speed=speed) / force_per_torque


def _map_ends(car: Sedan, engine: Floats) -> tuple[Floats, Floats]:
    """(n,) torque with closed and with open throttle [N m]; beyond the map's speeds that at its edge."""
    return np.interp(engine, car.map_speed, car.closed_torque), np.interp(engine, car.map_speed, car.full_torque)


def throttle_of(car: Sedan, *, accel: Floats, speed: Floats) -> Floats:
    """(n,) throttle opening for an acceleration: eqs. 8 and 9, then the inverse engine map, linearly interpolated.

    It is 0 where the engine's own braking is too much already, 1 where the engine cannot give as much.

    Args:
        car: the car.
        accel: (n,) acceleration, signed [m/s2].
        speed: (n,) [m/s], >= 0.
    """
    engine, _ = _transmission(car, speed)
    closed, full = _map_ends(car, engine)
    share = (engine_torque(car, accel=accel, speed=speed) - closed) / (full - closed)
    return np.interp(share, car.opening, car.map_throttle)


def acceleration_of(car: Sedan, *, throttle: Floats, speed: Floats) -> Floats:
    """(n,) acceleration that a throttle opening, 0 to 1, gives, signed [m/s2]: the inverse of `throttle_of`."""
    engine, force_per_torque = _transmission(car, speed)
    closed, full = _map_ends(car, engine)
    torque = closed + (full - closed) * np.interp(throttle, car.map_throttle, car.opening)
    accel: Floats = (torque * force_per_torque - _resistance(car, speed)) / (car.rotating * car.mass)
    return accel


def pressure_of(car: Sedan, *, decel: Floats, speed: Floats, mu: Floats) -> Floats:
    """(n,) master-cylinder pressure `P = F_b / K_b` [Pa], `F_b = -C_D A rho v^2 / 2 - m g f - delta m a` (eqs. 10, 11).

    The printed |F_b| would brake harder, the less is asked for, once the resistances alone exceed the demand; F_b is
    not below 0 here. It is not above `mu m g` either: the source's linear relation ends at the limit of the road.

    Args:
        car: the car.
        decel: (n,) demanded deceleration, -a, >= 0 [m/s2].
        speed: (n,) [m/s].
        mu: (n,) friction coefficient of the road.
    """
    force = car.rotating * car.mass * decel - _resistance(car, speed)
    pressure: Floats = np.clip(force, 0.0, mu * car.mass * G) / car.force_per_pressure
    return pressure


def deceleration_of(car: Sedan, *, pressure: Floats, speed: Floats, mu: Floats) -> Floats:
    """(n,) deceleration >= 0 [m/s2] under a pressure >= 0 [Pa] with the clutch open: the inverse of `pressure_of`."""
    force = np.minimum(pressure * car.force_per_pressure, mu * car.mass * G)
    decel: Floats = (force + _resistance(car, speed)) / (car.rotating * car.mass)
    return decel
