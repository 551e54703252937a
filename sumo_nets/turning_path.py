"""Turning paths made of a clothoid, an arc and the mirrored clothoid (Yan et al. 2025, Table 3)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["YAN_TABLE_3", "TurningPath", "turning_path"]

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

    @property
    def reach(self) -> float:
        """How far ahead of its beginning the turn ends [m]."""
        return float(self.points(2.0)[-1, 0])


YAN_TABLE_3: dict[int, TurningPath] = {
    10: TurningPath(r_turn=10, clothoid_angle=20.65, arc_angle=48.62),
    20: TurningPath(r_turn=16, clothoid_angle=21.85, arc_angle=46.42),
    30: TurningPath(r_turn=29, clothoid_angle=22.92, arc_angle=44.08),
}
"""Speed [km/h] -> path, as printed. The 20 km/h row turns 90.12 deg, the others 89.92."""


def turning_path(radius: float) -> tuple[TurningPath, float]:
    """A left turn by 90 deg and the speed of cars on it.

    Args:
        radius: of its arc [m], within the radii of `YAN_TABLE_3`.

    Returns:
        The path, and the speed [m/s]. For a radius of Table 3 both are as printed; in between the clothoid's angle and
        the speed are interpolated and the arc fills up to 90 deg, our assumption.

    Raises:
        ValueError: the radius is outside Table 3.
    """
    rows = sorted((path.r_turn, speed) for speed, path in YAN_TABLE_3.items())
    if not rows[0][0] <= radius <= rows[-1][0]:
        raise ValueError(f"turn_radius must be within {rows[0][0]:g} .. {rows[-1][0]:g} m, not {radius:g}")
    radii = [r for r, _ in rows]
    speed = float(np.interp(radius, radii, [v for _, v in rows])) / 3.6
    for path in YAN_TABLE_3.values():
        if path.r_turn == radius:
            return path, speed
    clothoid = float(np.interp(radius, radii, [YAN_TABLE_3[v].clothoid_angle for _, v in rows]))
    return TurningPath(r_turn=radius, clothoid_angle=clothoid, arc_angle=90.0 - 2 * clothoid), speed
