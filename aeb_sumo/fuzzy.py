"""Mamdani control surfaces: a rule base evaluated once on a grid, interpolated ever after.

scikit-fuzzy gives the membership functions; `skfuzzy.control` (300 ms for one inference of a 10 x 9 rule base) is the
reference that tests/reference/test_fuzzy.py compares with.
"""

from dataclasses import dataclass

import numpy as np
import skfuzzy
from numpy.typing import ArrayLike

from aeb_sumo.soa import Floats

__all__ = ["RuleBase", "Surface"]

_UNIVERSE_POINTS = 201  # of the output variable, for the centroid


@dataclass(frozen=True, kw_only=True, eq=False)
class RuleBase:
    """Two inputs, one output; min for AND, clipping for implication, max for aggregation, centroid to defuzzify.

    Attributes:
        x_range, y_range, z_range: universes of the inputs and the output.
        x_sets, y_sets: centre and sigma of each Gaussian input set, (nx, 2) and (ny, 2).
        z_sets: centre, width and slope of each generalised-bell output set, (nz, 3).
        rules: (nx, ny) index of the output set for every pair of input sets.
    """

    x_range: tuple[float, float]
    y_range: tuple[float, float]
    z_range: tuple[float, float]
    x_sets: Floats
    y_sets: Floats
    z_sets: Floats
    rules: np.ndarray[tuple[int, int], np.dtype[np.int64]]

    def __post_init__(self) -> None:
        if self.rules.shape != (len(self.x_sets), len(self.y_sets)):
            raise ValueError(f"rules must be {len(self.x_sets)} x {len(self.y_sets)}, not {self.rules.shape}")
        if self.rules.min() < 0 or self.rules.max() >= len(self.z_sets):
            raise ValueError(f"rules must name output sets 0..{len(self.z_sets) - 1}")
        for name in ("x_sets", "y_sets", "z_sets"):
            if np.any(np.diff(getattr(self, name)[:, 0]) <= 0):
                raise ValueError(f"centres of {name} must increase")

    def universe(self) -> Floats:
        """Points of the output universe."""
        return np.linspace(*self.z_range, _UNIVERSE_POINTS)

    def surface(self, nx: int, ny: int) -> "Surface":
        """Evaluate on a regular grid of `nx` by `ny` points.

        Single precision and one row at a time, for speed: it is accurate to 1e-4 of the universe.
        """
        x, y, z = np.linspace(*self.x_range, nx), np.linspace(*self.y_range, ny), self.universe()
        single = np.float32
        in_x = np.array([skfuzzy.gaussmf(x, c, s) for c, s in self.x_sets], single)
        in_y = np.array([skfuzzy.gaussmf(y, c, s) for c, s in self.y_sets], single)
        out = np.array([skfuzzy.gbellmf(z, a, b, c) for c, a, b in self.z_sets], single)
        moments = _centroid_weights(z).astype(single)
        values = np.empty((nx, ny))
        aggregate = np.empty((ny, len(z)), single)
        clipped = np.empty_like(aggregate)
        for row in range(nx):
            aggregate[:] = 0
            for k, shape in enumerate(out):
                strength = np.zeros(ny, single)
                for i, j in zip(*np.nonzero(self.rules == k), strict=True):
                    np.maximum(strength, np.minimum(in_x[i, row], in_y[j]), out=strength)
                np.minimum(strength[:, None], shape, out=clipped)
                np.maximum(aggregate, clipped, out=aggregate)
            area, moment = (aggregate @ moments).T
            values[row] = moment / area
        return Surface(self.x_range, self.y_range, values)


def _centroid_weights(z: Floats) -> Floats:
    """Weights (len(z), 2) that give area and first moment of a function that is linear between the points."""
    h = z[1] - z[0]
    area = np.full(len(z), h)
    area[[0, -1]] = h / 2
    moment = z * h
    moment[0] = h * (2 * z[0] + z[1]) / 6
    moment[-1] = h * (z[-2] + 2 * z[-1]) / 6
    return np.column_stack([area, moment])


@dataclass(frozen=True, eq=False)
class Surface:
    """Output on a regular grid; call it to interpolate, linearly, inputs saturating at the universes' ends."""

    x_range: tuple[float, float]
    y_range: tuple[float, float]
    values: Floats

    def __call__(self, x: ArrayLike, y: ArrayLike) -> Floats:
        """Outputs for inputs (n,) and (n,)."""
        nx, ny = self.values.shape
        i, fx = _cell(np.asarray(x, float), self.x_range, nx)
        j, fy = _cell(np.asarray(y, float), self.y_range, ny)
        v = self.values
        near = v[i, j] * (1 - fy) + v[i, j + 1] * fy
        far = v[i + 1, j] * (1 - fy) + v[i + 1, j + 1] * fy
        result: Floats = near * (1 - fx) + far * fx
        return result


def _cell(
    q: Floats, limits: tuple[float, float], n: int
) -> tuple[np.ndarray[tuple[int, ...], np.dtype[np.int64]], Floats]:
    """Index of the grid cell and the fraction within it."""
    at = (np.clip(q, *limits) - limits[0]) / (limits[1] - limits[0]) * (n - 1)
    cell = np.minimum(at.astype(np.int64), n - 2)
    return cell, at - cell
