"""What hides what: lines of sight against bodies and walls, seen from above; pure geometry.

Everything that hides is a set of straight pieces: a wall is one, a body its two diagonals. A line that passes through a
rectangle from outside to outside parts its corners, so it always crosses a diagonal, and inside the rectangle.
"""

from dataclasses import dataclass

import numpy as np

from aeb_sumo.compiled import kernel
from aeb_sumo.soa import Bools, Floats, Ints

__all__ = ["NOBODY", "Screens", "diagonals", "in_sight"]

NOBODY = -1
"""Owner of a screen that belongs to no vehicle."""


@dataclass(frozen=True)
class Screens:
    """Straight pieces that hide what is behind them, in order of their middles' x; make them with `of`.

    Attributes:
        pieces: (m, 4) x and y of either end [m].
        owner: (m,) slot of the vehicle they are part of, `NOBODY` for a wall.
        middle: (m,) x of their middles, rising [m].
        spread: the most that any of them reaches to either side of its middle in x [m].
    """

    pieces: Floats
    owner: Ints
    middle: Floats
    spread: float

    @classmethod
    def of(cls, pieces: Floats, owner: Ints) -> "Screens":
        """From pieces (m, 4) and their owners (m,) in any order."""
        middle = (pieces[:, 0] + pieces[:, 2]) / 2
        order = np.argsort(middle, kind="stable")
        spread = float(np.abs(pieces[:, 0] - pieces[:, 2]).max(initial=0.0)) / 2
        return cls(pieces[order], owner[order], middle[order], spread)


def diagonals(*, x: Floats, y: Floats, heading: Floats, length: Floats, width: Floats) -> Floats:
    """(2n, 4) diagonals of the bodies of n vehicles, first one of each, then the other of each [m].

    Args:
        x: (n,) centre of the front bumper [m].
        y: (n,) centre of the front bumper [m].
        heading: (n,) [rad].
        length: (n,) [m].
        width: (n,) [m].
    """
    cos, sin = np.cos(heading), np.sin(heading)
    back_x, back_y = x - length * cos, y - length * sin
    aside_x, aside_y = -sin * width / 2, cos * width / 2
    return np.vstack(
        [
            np.column_stack([x + aside_x, y + aside_y, back_x - aside_x, back_y - aside_y]),
            np.column_stack([x - aside_x, y - aside_y, back_x + aside_x, back_y + aside_y]),
        ]
    )


def in_sight(lines: Floats, ends: Ints, bodies: Screens, walls: Screens) -> Bools:
    """To whom one of several lines of sight is free.

    A line that only touches the end of a screen, or ends on it, is not free: there are no gaps in the corner of two
    walls.

    Args:
        lines: (k, p, 4) x and y of each eye, x and y of p points of what it looks at [m].
        ends: (k, 2) slots of the vehicles at either end, whose own screens do not count.
        bodies: what is in the way ...
        walls: ... and what else.

    Returns:
        (k,) one of the p lines crosses none of them.
    """
    return _in_sight(
        lines, ends, bodies.pieces, bodies.owner, bodies.middle, bodies.spread,
        walls.pieces, walls.owner, walls.middle, walls.spread,
    )  # fmt: skip


@kernel
def _in_sight(
    lines: Floats, ends: Ints, pieces: Floats, owner: Ints, middle: Floats, spread: float,
    more_pieces: Floats, more_owner: Ints, more_middle: Floats, more_spread: float,
) -> Bools:  # fmt: skip
    result = np.zeros(len(lines), np.bool_)
    for k in range(len(lines)):
        for p in range(lines.shape[1]):
            line = lines[k, p]
            if not _hides(line, ends[k], pieces, owner, middle, spread) and not _hides(
                line, ends[k], more_pieces, more_owner, more_middle, more_spread
            ):
                result[k] = True
                break
    return result


@kernel
def _hides(line: Floats, ends: Ints, pieces: Floats, owner: Ints, middle: Floats, spread: float) -> bool:
    x, y, to_x, to_y = line
    # Only screens whose bounding box overlaps the line's may cross it.
    first = int(np.searchsorted(middle, min(x, to_x) - spread))
    for j in range(first, len(middle)):
        if middle[j] > max(x, to_x) + spread:
            break
        if owner[j] != NOBODY and (owner[j] == ends[0] or owner[j] == ends[1]):
            continue
        one, other = pieces[j, 1], pieces[j, 3]
        if min(one, other) <= max(y, to_y) and max(one, other) >= min(y, to_y) and _cross(line, pieces[j]):
            return True
    return False


@kernel
def _cross(a: Floats, b: Floats) -> bool:
    """Whether two straight pieces, (4,) each, have a point in common; parallel ones have none."""
    ax, ay, bx, by = a[2] - a[0], a[3] - a[1], b[2] - b[0], b[3] - b[1]
    dx, dy = b[0] - a[0], b[1] - a[1]
    area = ax * by - ay * bx
    # How far along either piece the common point is, as a share times `area`.
    along_a, along_b = dx * by - dy * bx, dx * ay - dy * ax
    if area < 0:
        along_a, along_b, area = -along_a, -along_b, -area
    return bool(area > 0 and 0 <= along_a <= area and 0 <= along_b <= area)
