"""Failure to yield, as it comes about in the world."""

from aeb_sumo.drivers.errors import FailureToYield
from aeb_sumo.world.observe import Traffic, VClasses
from aeb_sumo.world.paths import Turn
from aeb_sumo.world.surroundings import overlook

__all__ = ["Yielding"]

_NEAR = 80.0  # m, an encounter begins when car and two-wheeler are this near, our assumption
_LEFT = frozenset("lL")


class Yielding:
    """Left-turning drivers who overlook an oncoming two-wheeler, and riders who overlook the car.

    Each pair of a driver and a rider is one encounter with one draw, whenever and however often they come near.

    Attributes:
        overlooked: (driver, rider) pairs in which the driver does not see the rider.
    """

    def __init__(self, traffic: Traffic, error: FailureToYield | None, seed: int) -> None:
        self._traffic = traffic
        self._error = error
        self._seed = seed
        self._met: set[tuple[str, str]] = set()
        self._blind: dict[str, set[str]] = {}
        self.overlooked: set[tuple[str, str]] = set()

    def step(self, turns: list[Turn]) -> None:
        """Draw for every new encounter."""
        if self._error is None:
            return
        t = self._traffic
        for _, vehicle in t.left:
            self._blind.pop(vehicle, None)
        riders = [s for s in t.present.tolist() if t.vclass[s] in VClasses.RIDERS]
        for turn in turns:
            if turn.path.direction not in _LEFT:
                continue
            driver = t.ids[turn.slot]
            for slot in riders:
                rider = t.ids[slot]
                if (driver, rider) in self._met:
                    continue
                if (t.x[slot] - t.x[turn.slot]) ** 2 + (t.y[slot] - t.y[turn.slot]) ** 2 > _NEAR**2:
                    continue
                self._met.add((driver, rider))
                fails, unaware = self._error.draw(self._seed, driver, rider)
                if fails:
                    self.overlooked.add((driver, rider))
                    self._hide(driver, rider)
                    if unaware:
                        self._hide(rider, driver)

    def _hide(self, who: str, whom: str) -> None:
        self._blind.setdefault(who, set()).add(whom)
        overlook(who, self._blind[who])
