"""Vehicles as oriented boxes: how far apart they are, whether they overlap, where; pure geometry."""

from dataclasses import dataclass

import numpy as np

from aeb_sumo.compiled import kernel
from aeb_sumo.soa import Floats

__all__ = ["Boxes", "distance", "may_have_touched", "middle_of_overlap", "parting_axis", "separation"]


@dataclass(frozen=True)
class Boxes:
    """Rectangles, (n,) each: centre [m], unit vector along the length, half length and half width [m]."""

    cx: Floats
    cy: Floats
    ux: Floats
    uy: Floats
    half_length: Floats
    half_width: Floats

    @classmethod
    def of(cls, x: Floats, y: Floats, heading: Floats, length: Floats, width: Floats) -> "Boxes":
        """From the centre of the front bumper, as SUMO gives it."""
        ux, uy = np.cos(heading), np.sin(heading)
        return cls(x - ux * length / 2, y - uy * length / 2, ux, uy, length / 2, width / 2)

    @property
    def parts(self) -> tuple[Floats, ...]:
        """The attributes in this order, for kernels."""
        return self.cx, self.cy, self.ux, self.uy, self.half_length, self.half_width

    def corners(self) -> Floats:
        """(n, 4, 2) corners, counter-clockwise from the front left [m]."""
        return _corners(self.parts)

    def local(self, point: Floats) -> Floats:
        """(n, 2) forward and left coordinates of points (n, 2) from the centre [m]."""
        dx, dy = point[:, 0] - self.cx, point[:, 1] - self.cy
        return np.stack([dx * self.ux + dy * self.uy, dy * self.ux - dx * self.uy], -1)


@kernel
def _corners(boxes: tuple[Floats, ...]) -> Floats:
    cx, cy, ux, uy, half_length, half_width = boxes
    corners = np.empty((len(cx), 4, 2))
    for k in range(len(cx)):
        along_x, along_y = ux[k] * half_length[k], uy[k] * half_length[k]
        aside_x, aside_y = -uy[k] * half_width[k], ux[k] * half_width[k]
        corners[k, 0] = cx[k] + along_x + aside_x, cy[k] + along_y + aside_y
        corners[k, 1] = cx[k] - along_x + aside_x, cy[k] - along_y + aside_y
        corners[k, 2] = cx[k] - along_x - aside_x, cy[k] - along_y - aside_y
        corners[k, 3] = cx[k] + along_x - aside_x, cy[k] + along_y - aside_y
    return corners


@kernel
def _widest_gap(a: tuple[Floats, ...], i: int, b: tuple[Floats, ...], j: int) -> tuple[float, float, float]:
    """Between two boxes along the axes of each: the largest gap, and the unit vector of its axis.

    If it is negative they overlap.
    """
    a_x, a_y, a_length, a_width, dx = a[2][i], a[3][i], a[4][i], a[5][i], b[0][j] - a[0][i]
    b_x, b_y, b_length, b_width, dy = b[2][j], b[3][j], b[4][j], b[5][j], b[1][j] - a[1][i]
    cos, sin = np.abs(a_x * b_x + a_y * b_y), np.abs(a_x * b_y - a_y * b_x)
    widest = np.abs(dx * a_x + dy * a_y) - (a_length + b_length * cos + b_width * sin), a_x, a_y
    gap = np.abs(dy * a_x - dx * a_y) - (a_width + b_length * sin + b_width * cos)
    if gap > widest[0]:
        widest = gap, -a_y, a_x
    gap = np.abs(dx * b_x + dy * b_y) - (b_length + a_length * cos + a_width * sin)
    if gap > widest[0]:
        widest = gap, b_x, b_y
    gap = np.abs(dy * b_x - dx * b_y) - (b_width + a_length * sin + a_width * cos)
    if gap > widest[0]:
        widest = gap, -b_y, b_x
    return widest


def separation(a: Boxes, b: Boxes) -> Floats:
    """Largest gap along any axis of the two boxes, pairwise, (n,) [m].

    By the separating-axis theorem they overlap if and only if it is negative; its magnitude is then the smallest
    penetration. When positive it is a lower bound of the distance (exact face to face).
    """
    return _separation(a.parts, b.parts)


@kernel
def _separation(a: tuple[Floats, ...], b: tuple[Floats, ...]) -> Floats:
    gaps = np.empty(len(a[0]))
    for k in range(len(gaps)):
        gaps[k] = _widest_gap(a, k, b, k)[0]
    return gaps


def distance(a: Boxes, b: Boxes) -> Floats:
    """Distance of the two boxes, pairwise, (n,) [m]; 0 where they touch or overlap."""
    apart = _corners_to_sides(a.corners(), b.corners())
    return np.where(separation(a, b) <= 0, 0.0, apart)


@kernel
def _corners_to_sides(own: Floats, other: Floats) -> Floats:
    """Smallest distance from any of the corners (n, 4, 2) of one box to any side of the other, (n,) [m]."""
    squared = np.full(len(own), np.inf)
    for corners, box in ((own, other), (other, own)):
        for k in range(len(own)):
            for side in range(4):
                (x, y), (next_x, next_y) = box[k, side], box[k, (side + 1) % 4]
                side_x, side_y = next_x - x, next_y - y
                for corner in range(4):
                    to_x, to_y = corners[k, corner, 0] - x, corners[k, corner, 1] - y
                    share = (to_x * side_x + to_y * side_y) / (side_x * side_x + side_y * side_y)
                    share = np.minimum(np.maximum(share, 0.0), 1.0)
                    off_x, off_y = to_x - share * side_x, to_y - share * side_y
                    squared[k] = np.minimum(squared[k], off_x * off_x + off_y * off_y)
    result: Floats = np.sqrt(squared)
    return result


def parting_axis(a: Boxes, b: Boxes) -> Floats:
    """(2,) unit vector along which two boxes, (1,) each, are farthest apart, or overlap least."""
    return np.array(_widest_gap(a.parts, 0, b.parts, 0)[1:])


@kernel
def may_have_touched(
    boxes: tuple[Floats, ...],
    wheeled: int,
    reach: Floats,
    dx: Floats,
    dy: Floats,
    turn: Floats,
) -> list[tuple[int, int]]:
    """Pairs, as rows, of boxes that may have touched during the step at whose end they are here.

    They are no farther apart than both their reaches, and touch at its end, or their relative motion along the axis
    that parts them then, and what their turning moved their ends, was longer than the gap left.

    Args:
        boxes: `Boxes.parts`, (n,) each.
        wheeled: rows from this one on are walkers.
        reach: (n,) from a centre to where the body may have been during the step [m].
        dx: (n,) motion [m].
        dy: (n,) motion [m].
        turn: (n,) sine of the turn.
    """
    pairs = []
    cx, cy, half_length, farthest = boxes[0], boxes[1], boxes[4], 2 * reach.max()
    line = cx if cx.max() - cx.min() >= cy.max() - cy.min() else cy
    order = np.argsort(line)
    for first in range(len(order)):
        i = order[first]
        for second in range(first + 1, len(order)):
            j = order[second]
            if line[j] > line[i] + farthest:
                break
            x, y, both = cx[i] - cx[j], cy[i] - cy[j], reach[i] + reach[j]
            if x * x + y * y <= both * both and min(i, j) < wheeled:
                gap, nx, ny = _widest_gap(boxes, i, boxes, j)
                turned = (turn[i] + turn[j]) * (2 * (half_length[i] + half_length[j]))
                if gap < np.abs((dx[i] - dx[j]) * nx + (dy[i] - dy[j]) * ny) + turned:
                    pairs.append((i, j))
    return pairs


def middle_of_overlap(boxes: Boxes, skin: float = 0.02) -> Floats:
    """Centroid of the overlap of two boxes, each grown by a skin so that a mere touch has one [m]."""
    grown = Boxes(boxes.cx, boxes.cy, boxes.ux, boxes.uy, boxes.half_length + skin, boxes.half_width + skin)
    polygon, clip = grown.corners()
    for start, end in zip(clip, np.roll(clip, -1, 0), strict=True):
        edge = end - start
        side = edge[0] * (polygon[:, 1] - start[1]) - edge[1] * (polygon[:, 0] - start[0])
        kept = []
        for k in range(len(polygon)):
            nxt = (k + 1) % len(polygon)
            if side[k] >= 0:
                kept.append(polygon[k])
            if side[k] * side[nxt] < 0:
                kept.append(polygon[k] + (polygon[nxt] - polygon[k]) * side[k] / (side[k] - side[nxt]))
        polygon = np.array(kept).reshape(-1, 2)
        if not len(polygon):  # farther apart than the skin: the middle between them
            return np.array([boxes.cx.mean(), boxes.cy.mean()])
    middle: Floats = polygon.mean(0)
    return middle
