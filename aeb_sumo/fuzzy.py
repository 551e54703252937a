"""Mamdani control surfaces: a rule base evaluated once on a grid, interpolated ever after.

scikit-fuzzy gives the membership functions; `skfuzzy.control` (300 ms for one inference of a 10 x 9 rule base) is the
reference that tests/reference/test_fuzzy.py compares with.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from aeb_sumo.compiled import kernel
from aeb_sumo.errors import InputError
from aeb_sumo.soa import Floats

__all__ = ["RuleBase", "Surface"]

_Singles = np.ndarray[tuple[int, ...], np.dtype[np.float32]]

_UNIVERSE_POINTS = 201  # of the output variable, for the centroid


@dataclass(frozen=True, kw_only=True, eq=False)
class RuleBase:
    """Two inputs, one output; min for AND, clipping for implication, max for aggregation, centroid to defuzzify.

    Attributes:
        x_range, y_range, z_range: universes of the inputs and the output.
        x_sets, y_sets: centre and sigma of each Gaussian input set, (nx, 2) and (ny, 2).
        z_sets: the output sets: centre and sigma of each Gaussian, (nz, 2), or centre, width and slope of each
            generalised bell, (nz, 3).
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
        """Raises `InputError` for sets or rules that do not fit."""
        for name, columns in (("x_sets", (2,)), ("y_sets", (2,)), ("z_sets", (2, 3))):
            sets = getattr(self, name)
            if sets.ndim != 2 or len(sets) == 0 or sets.shape[1] not in columns:
                raise InputError(f"{name} must have {' or '.join(map(str, columns))} columns, not shape {sets.shape}")
            if not np.all(np.diff(sets[:, 0]) > 0):
                raise InputError(f"centres of {name} must increase, not {sets[:, 0].tolist()}")
            if not np.all(sets[:, 1:] > 0):
                raise InputError(f"widths of {name} must be above 0, not {sets[:, 1:].min():g}")
        if self.rules.shape != (len(self.x_sets), len(self.y_sets)):
            raise InputError(f"rules must be {len(self.x_sets)} x {len(self.y_sets)}, not {self.rules.shape}")
        outside = (self.rules < 0) | (self.rules >= len(self.z_sets))
        if outside.any():
            raise InputError(f"rules must name output sets 0..{len(self.z_sets) - 1}, not {self.rules[outside][0]}")

    def universe(self) -> Floats:
        """Points of the output universe."""
        return np.linspace(*self.z_range, _UNIVERSE_POINTS)

    def output_sets(self) -> Floats:
        """Membership of every point of the output universe in every output set, (nz, points)."""
        import skfuzzy  # noqa: PLC0415 - takes long, and few strategies need it

        z = self.universe()
        if self.z_sets.shape[1] == 2:
            return np.array([skfuzzy.gaussmf(z, c, s) for c, s in self.z_sets])
        return np.array([skfuzzy.gbellmf(z, a, b, c) for c, a, b in self.z_sets])

    def surface(self, lines: int = 60) -> "Surface":
        """Evaluate on a grid with `lines` lines from each centre of an input set to where the next set takes over.

        The surface is steep where the sets are narrow, and creased at their centres and where neighbours are equal;
        such a grid is fine in the first and has a line on each of the second. Single precision and one row at a time,
        for speed: that is accurate to 1e-4 of the universe.
        """
        import skfuzzy  # noqa: PLC0415

        x, y = _grid(self.x_sets, self.x_range, lines), _grid(self.y_sets, self.y_range, lines)
        single = np.float32
        in_x = np.array([skfuzzy.gaussmf(x, c, s) for c, s in self.x_sets], single)
        in_y = np.array([skfuzzy.gaussmf(y, c, s) for c, s in self.y_sets], single)
        out = self.output_sets().astype(single)
        moments = _centroid_weights(self.universe()).astype(single)
        values = np.empty((len(x), len(y)))
        aggregate = np.empty((len(y), _UNIVERSE_POINTS), single)
        for row in range(len(x)):
            _infer(in_x[:, row].copy(), in_y, self.rules, out, aggregate)
            area, moment = (aggregate @ moments).T
            values[row] = moment / area
        return Surface(x, y, values)


@kernel
def _infer(
    in_x: _Singles, in_y: _Singles, rules: np.ndarray[tuple[int, int], np.dtype[np.int64]], out: _Singles,
    aggregate: _Singles,
) -> None:  # fmt: skip
    """Fill in `aggregate`, (n, points) over the output universe, for memberships (nx,) of x and (ny, n) of all y."""
    strength = np.zeros((len(out), in_y.shape[1]), np.float32)
    for i in range(rules.shape[0]):
        for j in range(rules.shape[1]):
            k = rules[i, j]
            for y in range(in_y.shape[1]):
                strength[k, y] = max(strength[k, y], min(in_x[i], in_y[j, y]))
    aggregate[:] = 0
    for y in range(in_y.shape[1]):
        for k in range(len(out)):
            for z in range(out.shape[1]):
                aggregate[y, z] = max(aggregate[y, z], min(strength[k, y], out[k, z]))


def _grid(sets: Floats, limits: tuple[float, float], lines: int) -> Floats:
    """Grid lines of one input: `lines` equal steps between its creases and the ends of its universe."""
    centre, sigma = sets.T
    equal = (centre[:-1] * sigma[1:] + centre[1:] * sigma[:-1]) / (sigma[:-1] + sigma[1:])
    knots = np.unique(np.clip(np.concatenate([centre, equal, limits]), *limits))
    steps = np.arange((len(knots) - 1) * lines + 1) / lines
    result: Floats = np.interp(steps, np.arange(len(knots)), knots)
    return result


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
    """Output on a grid; call it to interpolate, linearly, inputs saturating at the universes' ends.

    Attributes:
        x, y: increasing grid lines, (nx,) and (ny,).
        values: output, (nx, ny).
    """

    x: Floats
    y: Floats
    values: Floats

    def __call__(self, x: ArrayLike, y: ArrayLike) -> Floats:
        """Outputs for inputs (n,) and (n,)."""
        result: Floats = _interpolated(np.asarray(x, float), np.asarray(y, float), self.x, self.y, self.values)
        return result


@kernel
def _interpolated(x: Floats, y: Floats, lines_x: Floats, lines_y: Floats, v: Floats) -> Floats:
    result = np.empty(len(x))
    for k in range(len(x)):
        i, fx = _cell(x[k], lines_x)
        j, fy = _cell(y[k], lines_y)
        near = v[i, j] * (1 - fy) + v[i, j + 1] * fy
        far = v[i + 1, j] * (1 - fy) + v[i + 1, j + 1] * fy
        result[k] = near * (1 - fx) + far * fx
    return result


@kernel
def _cell(q: float, lines: Floats) -> tuple[int, float]:
    """Index of the grid cell and the fraction within it."""
    q = min(max(q, lines[0]), lines[-1])
    cell = min(max(int(np.searchsorted(lines, q, side="right")) - 1, 0), len(lines) - 2)
    return cell, (q - lines[cell]) / (lines[cell + 1] - lines[cell])
