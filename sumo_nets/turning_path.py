"""Turning paths made of a clothoid, an arc and the mirrored clothoid (Yan et al. 2025, Table 3)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["YAN_TABLE_3", "TurningPath"]

_FINE = 0.005  # m, integration step: the end point is then exact to well below a millimetre


@dataclass(frozen=True, kw_only=True)
class TurningPath:
    """A left turn: curvature 1/r_straight -> 1/r_turn over a clothoid, an arc, and back.

    Attributes:
        r_straight: radius at both ends [m] (printed).
        r_turn: radius of the arc [m] (printed).
        clothoid_angle: heading change of one clothoid [deg] (printed).
        arc_angle: heading change of the arc [deg] (printed).
    """

    r_straight: float = 1500.0
    r_turn: float
    clothoid_angle: float
    arc_angle: float

    def points(self, spacing: float = 1.0) -> NDArray[np.float64]:
        """The path from (0, 0) heading along +x, turning to the left (+y).

        The clothoid is `Lc = 2 alpha / (k1 + k2)` long, the arc `R beta` (shared/seeds.md 4.2).

        Args:
            spacing: distance between points along the path [m]; the end point is always included.

        Returns:
            (n, 2) forward and left coordinates [m].
        """
        k1, k2 = 1 / self.r_straight, 1 / self.r_turn
        clothoid = 2 * np.radians(self.clothoid_angle) / (k1 + k2)
        arc = self.r_turn * np.radians(self.arc_angle)
        total = 2 * clothoid + arc
        s = np.linspace(0.0, total, int(np.ceil(total / _FINE)) + 1)
        curvature = np.interp(s, [0, clothoid, clothoid + arc, total], [k1, k2, k2, k1])
        ds = np.diff(s)
        heading = np.concatenate([[0.0], np.cumsum((curvature[1:] + curvature[:-1]) / 2 * ds)])
        middle = (heading[1:] + heading[:-1]) / 2
        fine = np.vstack([[0.0, 0.0], np.cumsum(np.column_stack([np.cos(middle), np.sin(middle)]) * ds[:, None], 0)])
        at = np.append(np.arange(0.0, total - spacing / 2, spacing), total)
        return np.column_stack([np.interp(at, s, fine[:, 0]), np.interp(at, s, fine[:, 1])])


YAN_TABLE_3: dict[int, TurningPath] = {
    10: TurningPath(r_turn=10, clothoid_angle=20.65, arc_angle=48.62),
    20: TurningPath(r_turn=16, clothoid_angle=21.85, arc_angle=46.42),
    30: TurningPath(r_turn=29, clothoid_angle=22.92, arc_angle=44.08),
}
"""Speed [km/h] -> path, as printed. The 20 km/h row turns 90.12 deg, the others 89.92."""
