"""Batched filters against one filterpy filter per vehicle: `python tests/benchmarks/filters.py`.

Both do the same step on the same numbers, in turns within one run; the ratio of their shortest times, which
say least about what else the machine does, is what counts.
"""

import time

import numpy as np
from filterpy.kalman import KalmanFilter

from aeb_sumo.kalman import Gaussian, predict, update
from aeb_sumo.perception.measurable import Measurable
from aeb_sumo.perception.suites import suite
from aeb_sumo.perception.tracking import track_init, track_step
from aeb_sumo.vehicle.friction import TIE, FrictionParams, friction_init, friction_step, jacobian, reference_filter

N = 1000
DT = 0.04
RNG = np.random.default_rng(1)


def race(name, batched, singles, rounds=20, repeat=5):
    fast, slow = [], []
    for _ in range(rounds):
        start = time.perf_counter()
        for _ in range(repeat):
            batched()
        fast.append((time.perf_counter() - start) / repeat)
        start = time.perf_counter()
        singles()
        slow.append(time.perf_counter() - start)
    fast, slow = min(fast) * 1e3, min(slow) * 1e3
    print(f"{name:20s} {N} x filterpy {slow:7.1f} ms   batched {fast:6.3f} ms   ratio {slow / fast:5.0f}")


def friction():
    params = FrictionParams()
    force_x, force_y = RNG.normal(0, 2000, (2, N, 4))
    steer, ax, ay, yaw = RNG.normal(0, 0.1, (4, N))
    forces = {"force_x": force_x, "force_y": force_y, "steer": steer}
    state = friction_init(params, N, 0.8)
    # filterpy gets its Jacobians for nothing; the batched step works them out.
    rows = np.concatenate([jacobian(params.car, **forces), np.broadcast_to(TIE, (N, 2, 4))], axis=1)
    z = np.column_stack([ax, ay, yaw, np.zeros((N, 2))])
    filters = [reference_filter(params, 0.8, DT) for _ in range(N)]

    def batched():
        nonlocal state
        state = friction_step(params, state, **forces, accel_x=ax, accel_y=ay, yaw_accel=yaw, dt=DT)

    def singles():
        for f, h, measured in zip(filters, rows, z, strict=True):
            f.predict()
            f.update(measured, lambda _, h=h: h, lambda x, h=h: h @ x)

    race("friction, 4 states", batched, singles)


def tracker():
    f = np.array([[1, DT, DT**2 / 2], [0, 1, DT], [0, 0, 1]])
    q, r = np.eye(3) * 0.01, np.array([0.04, 0.01])
    z = RNG.normal(size=(2, N))
    state = Gaussian(np.zeros((N, 3)), np.tile(np.eye(3), (N, 1, 1)))
    filters = [KalmanFilter(3, 2) for _ in range(N)]
    for each in filters:
        each.x, each.F, each.Q, each.R, each.H = np.zeros(3), f, q, np.diag(r), np.eye(3)[:2]

    def batched():
        nonlocal state
        state = predict(state, f, q)
        for row, variance, measured in zip(np.eye(3), r, z, strict=False):
            state = update(state, row, variance, measured)

    def singles():
        for each, measured in zip(filters, z.T, strict=True):
            each.predict()
            each.update(measured)

    race("tracker, 3 states", batched, singles)


def sensing():
    """All that the fusion suite does for a vehicle in a frame, against the filtering that is part of it."""
    fusion, keys = suite("fusion"), np.arange(1, N + 1, dtype=np.uint64)
    zero, gap = np.zeros(N), RNG.uniform(10, 60, N)
    seen = Measurable(np.ones(N, bool), gap, zero + 5.0, zero, zero, zero, zero, zero, zero + 1.0, zero, zero)
    state, time = track_init(fusion, keys, DT), 0.0
    along = [KalmanFilter(3, 2) for _ in range(N)]
    across = [KalmanFilter(2, 1) for _ in range(N)]
    for one, other in zip(along, across, strict=True):
        one.H, other.H = np.eye(3)[:2], np.eye(2)[:1]

    def batched():
        nonlocal state, time
        time += fusion.cycle
        state = track_step(fusion, state, seen, time=time, dt=fusion.cycle)

    def singles():
        for one, other, z in zip(along, across, gap, strict=True):
            for filtered, measured in ((one, [z, -5.0]), (other, [0.0])):
                filtered.predict()
                for _ in fusion.sensors:
                    filtered.update(measured)

    race("radar + camera", batched, singles)


if __name__ == "__main__":
    friction()
    tracker()
    sensing()
