"""Who can see whom in the world of the current step, past other vehicles and buildings."""

import numpy as np

from aeb_sumo.perception.occlusion import NOBODY, Screens, diagonals, in_sight
from aeb_sumo.soa import Bools, Floats, Ints
from aeb_sumo.world.observe import Traffic

__all__ = ["Sightlines"]

_POINTS = (0.5, 0.0, 1.0)  # of the target's length, from its front


class Sightlines:
    """Lines of sight between vehicles, as seen from above.

    Motor vehicles that are followed, which are all those near junctions where others cross, and buildings hide what is
    behind them, whatever their heights; two-wheelers and pedestrians are too small to hide anybody, our assumption.
    """

    def __init__(self, traffic: Traffic, walls: Floats) -> None:
        """`walls`: (m, 4) of `aeb_sumo.world.buildings.walls`."""
        self._traffic = traffic
        self._walls = Screens.of(walls, np.full(len(walls), NOBODY))
        self._bodies: Screens | None = None

    def step(self) -> None:
        """The vehicles have moved."""
        self._bodies = None

    def visible(self, ego: Ints, other: Ints, *, setback: float = 0.0) -> Bools:
        """Whether each ego has a free line of sight to its other.

        One to the middle, the front or the rear of the other's centre line is enough: who sees either end knows that
        there is a vehicle, while a corner that shows a hand's breadth beside a lorry is not yet one. Range and field
        of view are not asked here.

        Args:
            ego: (k,) slots of those who look.
            other: (k,) slots of those they look for.
            setback: how far behind the centre of the front bumper the eye is [m]; 0: a sensor in the bumper.
        """
        t, k = self._traffic, len(ego)
        if not k:
            return np.zeros(0, np.bool_)
        heading = t.heading[other]
        back = np.multiply.outer(t.length[other], _POINTS)
        lines = np.empty((k, len(_POINTS), 4))
        lines[..., 0] = (t.x[ego] - setback * np.cos(t.heading[ego]))[:, None]
        lines[..., 1] = (t.y[ego] - setback * np.sin(t.heading[ego]))[:, None]
        lines[..., 2] = t.x[other][:, None] - back * np.cos(heading)[:, None]
        lines[..., 3] = t.y[other][:, None] - back * np.sin(heading)[:, None]
        return in_sight(lines, np.column_stack([ego, other]), self._bodies_now(), self._walls)

    def _bodies_now(self) -> Screens:
        if self._bodies is None:
            t = self._traffic
            rows = (t.followed & t.here & ~t.vulnerable).nonzero()[0]
            pieces = diagonals(
                x=t.x[rows], y=t.y[rows], heading=t.heading[rows], length=t.length[rows], width=t.width[rows]
            )
            self._bodies = Screens.of(pieces, np.tile(rows, 2))
        return self._bodies
