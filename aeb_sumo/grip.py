"""What each equipped vehicle knows of the road's friction: the truth, or its own running estimate."""

import numpy as np

from aeb_sumo.drivers.streams import number
from aeb_sumo.perception.noise import Keys, normals
from aeb_sumo.soa import Floats, Ints, fitted, put, take
from aeb_sumo.units import G
from aeb_sumo.vehicle.car import Car
from aeb_sumo.vehicle.friction import (
    FrictionParams,
    friction_estimate,
    friction_init,
    friction_step,
    straight_forces,
)
from aeb_sumo.vehicle.tyre import Tyre
from aeb_sumo.world.friction import Friction
from aeb_sumo.world.observe import Traffic

__all__ = ["Grip"]

_WHEEL_SPEED = 0.005  # m/s, noise of a wheel's speed against that of the car within 0.01 s, our assumption
_WALKING = 2.0  # m/s, our assumption: slower than this, wheel sensors tell nothing of slip
_GATE = 0.1  # of the weight, our assumption: below, that noise is as large as what there is to be seen


class Grip:
    """Friction as the vehicles know it.

    An estimating vehicle enters with a prior, or with the truth of that place, as if from the drive before; from there
    on it learns from its own wheels and accelerometer whenever it accelerates or brakes, and from nothing else. Both
    are noisy. Its model of tyre and load is the plant's own and there is no grade, our assumption: that is kinder than
    life. Curves are left out, as in the source (Lin et al. 2021, 1.3).
    """

    def __init__(
        self, traffic: Traffic, friction: Friction, *, estimates: bool, prior: float | None, seed: int
    ) -> None:
        self._traffic = traffic
        self._friction = friction
        self._estimates = estimates
        self._prior = prior
        self._seed = seed
        self._params, self._car, self._tyre = FrictionParams(gate=_GATE), Car(), Tyre()
        self._filter = friction_init(self._params, 0, np.zeros(0))
        self._keys: Keys = np.zeros(0, np.uint64)
        self._steps: Ints = np.zeros(0, np.int64)

    def depart(self, slot: int) -> None:
        """An equipped vehicle enters."""
        if not self._estimates:
            return
        if slot >= len(self._keys):
            size = self._traffic.capacity
            grown = friction_init(self._params, size, np.ones(size))
            put(grown, np.arange(len(self._keys)), self._filter)
            self._filter = grown
            self._keys, self._steps = fitted(self._keys, size), fitted(self._steps, size)
        row = np.array([slot])
        put(
            self._filter,
            row,
            friction_init(self._params, 1, self._friction.at(row) if self._prior is None else self._prior),
        )
        self._keys[slot] = number(self._seed, "accelerometer", self._traffic.ids[slot])
        self._steps[slot] = 0

    def step(self, rows: Ints) -> None:
        """The equipped vehicles in these slots have driven another step."""
        if not self._estimates or not len(rows):
            return
        t = self._traffic
        rows = rows[~t.fresh[rows] & (t.speed[rows] > _WALKING)]
        forces = straight_forces(
            self._car, self._tyre, accel=t.accel[rows], speed=t.speed[rows], mu=self._friction.at(rows)
        )
        still = np.zeros(len(rows))
        average = np.sqrt(self._params.period / t.dt)  # noise falls with the length of the step, as in `FrictionParams`
        keys, steps = self._keys[rows], self._steps[rows]
        slip = _WHEEL_SPEED * average / t.speed[rows]
        for wheel in range(4):
            load = self._car.mass * G / 4  # roughly: a slip of so much is a force of so much
            forces[:, wheel] -= self._tyre.c_x * load * slip * normals(keys, steps, 1 + wheel)
        measured = t.accel[rows] + self._params.sigma_accel * average * normals(keys, steps, 0)
        self._steps[rows] += 1
        state = friction_step(
            self._params,
            take(self._filter, rows),
            force_x=forces,
            force_y=np.zeros_like(forces),
            steer=still,
            accel_x=measured,
            accel_y=still,
            yaw_accel=still,
            dt=t.dt,
        )
        put(self._filter, rows, state)

    def known(self, rows: Ints) -> Floats:
        """(n,) friction coefficient as the vehicles in these slots know it."""
        if not self._estimates:
            return self._friction.at(rows)
        return friction_estimate(take(self._filter, rows))
