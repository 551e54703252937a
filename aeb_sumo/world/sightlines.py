"""Who can see whom in the world of the current step, past other vehicles and buildings."""

import numpy as np

from aeb_sumo.perception.occlusion import NOBODY, Screens, diagonals, hidden
from aeb_sumo.soa import Bools, Floats, Ints
from aeb_sumo.world.observe import Traffic

__all__ = ["Sightlines"]

_POINTS = (0.5, 0.0, 1.0)  # of the target's length, from its front


class Sightlines:
    """Lines of sight between vehicles, as seen from above.

    Motor vehicles and buildings hide what is behind them, whatever their heights; two-wheelers and pedestrians are too
    small to hide anybody, our assumption.
    """

    def __init__(self, traffic: Traffic, walls: Floats) -> None:
        """`walls`: (m, 4) of `aeb_sumo.world.buildings.walls`."""
        self._traffic = traffic
        self._walls = Screens.of(walls, np.full(len(walls), NOBODY))

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
        t, unseen = self._traffic, np.arange(len(ego))
        result = np.zeros(len(ego), np.bool_)
        if not len(ego):
            return result
        eye_x = t.x[ego] - setback * np.cos(t.heading[ego])
        eye_y = t.y[ego] - setback * np.sin(t.heading[ego])
        bodies = self._bodies_between(np.append(ego, other))
        for share in _POINTS:
            e, o = ego[unseen], other[unseen]
            back = share * t.length[o]
            there = t.x[o] - back * np.cos(t.heading[o]), t.y[o] - back * np.sin(t.heading[o])
            lines, ends = np.column_stack([eye_x[unseen], eye_y[unseen], *there]), np.column_stack([e, o])
            free = ~hidden(lines, ends, bodies)
            if len(self._walls.pieces):
                free[free] = ~hidden(lines[free], ends[free], self._walls)
            result[unseen[free]] = True
            unseen = unseen[~free]
            if not len(unseen):
                break
        return result

    def _bodies_between(self, slots: Ints) -> Screens:
        """The vehicles that may stand between any of these: those within the rectangle around them all."""
        t, rows = self._traffic, self._traffic.present
        reach = float(t.length[rows].max(initial=0.0))
        inside = ~t.vulnerable[rows]
        for at in (t.x, t.y):
            inside &= (at[rows] >= at[slots].min() - reach) & (at[rows] <= at[slots].max() + reach)
        rows = rows[inside]
        pieces = diagonals(
            x=t.x[rows], y=t.y[rows], heading=t.heading[rows], length=t.length[rows], width=t.width[rows]
        )
        return Screens.of(pieces, np.tile(rows, 2))
