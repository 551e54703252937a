"""Failure to yield, as it comes about in the world."""

import numpy as np

from aeb_sumo.drivers.errors import FailureToYield
from aeb_sumo.world.observe import Traffic, VClasses
from aeb_sumo.world.paths import Paths
from aeb_sumo.world.surroundings import overlook

__all__ = ["Yielding"]

_NEAR = 80.0  # m, an encounter begins when car and two-wheeler are this near, our assumption
_STANDS = 0.5  # m/s, slower than this is standing to the eye, our assumption
_LEFT = frozenset("lL")


class Yielding:
    """Left-turning drivers who overlook oncoming two-wheelers, and riders who overlook the car.

    Attributes:
        overlooked: (driver, rider) pairs in which the driver does not see the rider.
    """

    def __init__(self, traffic: Traffic, paths: Paths, error: FailureToYield | None, seed: int) -> None:
        self._traffic = traffic
        self._paths = paths
        self._error = error
        self._seed = seed
        self._fails: dict[tuple[str, str], bool] = {}  # (driver, junction)
        self._blind: dict[str, set[str]] = {}
        self.overlooked: set[tuple[str, str]] = set()
        self._unaware: dict[tuple[str, str], float] = {}  # (rider, driver) -> how long the car has been standing [s]

    def step(self) -> None:
        """Let new encounters of drivers who fail with oncoming riders begin."""
        if self._error is None:
            return
        t = self._traffic
        for _, vehicle in t.left:
            self._blind.pop(vehicle, None)
        riders = t.present[[t.vclass[s] in VClasses.RIDERS for s in t.present.tolist()]]
        for ego, user in zip(self._paths.turns.slot.tolist(), self._paths.turns.user.tolist(), strict=True):
            path = self._paths.users[user][0]
            if path.direction not in _LEFT or t.vclass[ego] not in VClasses.DRIVEN:
                continue
            driver = t.ids[ego]
            key = driver, path.junction
            if key not in self._fails:
                self._fails[key] = self._error.driver_fails(self._seed, *key)
            if not self._fails[key]:
                continue
            near = np.hypot(t.x[riders] - t.x[ego], t.y[riders] - t.y[ego]) < _NEAR
            oncoming = np.cos(t.heading[riders] - path.heading[0]) < -0.5
            for slot in riders[near & oncoming].tolist():
                rider = t.ids[slot]
                if (driver, rider) not in self.overlooked:
                    self.overlooked.add((driver, rider))
                    self._hide(driver, rider)
                    if self._error.rider_fails(self._seed, driver, rider):
                        self._hide(rider, driver)
                        self._unaware[rider, driver] = 0.0
        self._notice(self._error.rider_reaction)

    def _notice(self, reaction: float) -> None:
        """Riders see at last a car that stands in their way."""
        t = self._traffic
        for (rider, driver), standing in list(self._unaware.items()):
            if rider not in t.slot or driver not in t.slot:
                del self._unaware[rider, driver]
            elif t.speed[t.slot[driver]] > _STANDS:
                self._unaware[rider, driver] = 0.0
            elif standing + t.dt < reaction:
                self._unaware[rider, driver] = standing + t.dt
            else:
                del self._unaware[rider, driver]
                self._blind[rider].discard(driver)
                overlook(rider, self._blind[rider])

    def _hide(self, who: str, whom: str) -> None:
        self._blind.setdefault(who, set()).add(whom)
        overlook(who, self._blind[who])
