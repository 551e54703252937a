"""Where the planned paths of vehicles and those of persons on foot meet."""

import numpy as np

from aeb_sumo.perception.crossing import crossing_zone
from aeb_sumo.soa import Floats, Ints
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.paths import Paths
from aeb_sumo.world.walkers import Walkers

__all__ = ["Footpaths"]

_SPACING = 0.5  # m between the points of a path
_FORESIGHT = 8.0  # m that the path of a walker is followed: five seconds at a brisk pace, our assumption
# A vehicle looks as far as it takes to stop so gently after so long, and a little farther, our assumption.
_GENTLY = 4.0  # m/s2
_TIME = 1.5  # s
_MORE = 10.0  # m


class Footpaths:
    """Finds walkers in or beside the way of vehicles, at junctions and between them."""

    def __init__(self, traffic: Traffic, paths: Paths, walkers: Walkers) -> None:
        self._traffic = traffic
        self._paths = paths
        self._walkers = walkers

    def crossings(self, egos: Ints) -> tuple[Ints, Ints, Floats]:
        """Pairs of a vehicle and a walker near its way.

        Args:
            egos: slots of the vehicles.

        Returns:
            Slots of vehicles (k,), of walkers (k,), and (k, 4) distances from their fronts along their paths to where
            these meet: the vehicle's from and to, the walker's from and to [m]; nan where they do not.
        """
        t, others = self._traffic, self._traffic.walkers
        dx = t.x[others] - t.x[egos][:, None]
        dy = t.y[others] - t.y[egos][:, None]
        reach = t.speed[egos] * _TIME + t.speed[egos] ** 2 / (2 * _GENTLY) + _MORE
        ahead = dx * np.cos(t.heading[egos])[:, None] + dy * np.sin(t.heading[egos])[:, None] > -1.0
        i, j = np.nonzero(ahead & (np.hypot(dx, dy) < reach[:, None]))
        ways = {k: self._with_heading(self._paths.ahead(int(egos[k]), reach[k], _SPACING)) for k in np.unique(i)}
        walks = {k: self._with_heading(self._walkers.path(int(others[k]), _FORESIGHT, _SPACING)) for k in np.unique(j)}
        zones = np.full((len(i), 4), np.nan)
        for row, (k, m) in enumerate(zip(i, j, strict=True)):
            width = (t.width[egos[k]] + t.width[others[m]]) / 2
            zone = crossing_zone(*ways[k], *walks[m], width=width, spacing=_SPACING, on_foot=True)
            if zone is not None:
                zones[row] = zone.own_from, zone.own_to, zone.other_from, zone.other_to
        return egos[i], others[j], zones

    @staticmethod
    def _with_heading(points: Floats) -> tuple[Floats, Floats]:
        if len(points) < 2:
            return points, np.zeros(len(points))
        tangent = np.gradient(points, axis=0)
        return points, np.arctan2(tangent[:, 1], tangent[:, 0])
