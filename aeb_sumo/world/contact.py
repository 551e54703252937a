"""Contact of vehicles as oriented boxes, swept over a step; pure geometry.

A crash is a contact: the boxes of two vehicles touch while they approach each other. SUMO's own test looks along a lane
(or at shapes inside a junction), at the end of a step, and calls either vehicle the collider.
"""

from dataclasses import dataclass

import numpy as np

from aeb_sumo.compiled import kernel
from aeb_sumo.soa import Bools, Floats, Ints
from aeb_sumo.world.observe import Traffic

__all__ = ["Boxes", "Impact", "distance", "impact", "separation", "touching"]

_SAMPLES = np.linspace(0.0, 1.0, 9)  # of a step, for vehicles that may pass each other within it
_BISECTIONS = 20  # 0.1 s / 8 / 2^20: below a microsecond
_FACE = 0.3  # m: how near to a bumper a contact counts as one on that bumper


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


def _poses(t: Traffic, slots: Ints, when: Floats | float) -> tuple[Floats, Floats, Floats]:
    """Front bumper and heading a fraction `when` into the last step, linear in between."""
    turn = (t.heading[slots] - t.old_heading[slots] + np.pi) % (2 * np.pi) - np.pi
    return (
        t.old_x[slots] + (t.x[slots] - t.old_x[slots]) * when,
        t.old_y[slots] + (t.y[slots] - t.old_y[slots]) * when,
        t.old_heading[slots] + turn * when,
    )


def _boxes_at(t: Traffic, slots: Ints, when: Floats | float) -> Boxes:
    return Boxes.of(*_poses(t, slots, when), t.length[slots], t.width[slots])


def jumped(t: Traffic, slots: Ints) -> Bools:
    """Vehicles whose move in the last step was no motion: new to us, teleported or put on another lane at once."""
    dx, dy = t.x[slots] - t.old_x[slots], t.y[slots] - t.old_y[slots]
    cos, sin = np.cos(t.old_heading[slots]), np.sin(t.old_heading[slots])
    driven = (t.old_speed[slots] + t.speed[slots]) / 2 * t.dt
    # In a curve the chord is shorter than the way driven, and turned against the old heading.
    ahead, sideways = dx * cos + dy * sin - driven, np.abs(dy * cos - dx * sin)
    result: Bools = t.sudden[slots] | (np.abs(ahead) > 1.0 + 0.5 * driven) | (sideways > 0.6 + 0.3 * driven)
    return result


@kernel
def _may_have_touched(
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


def touching(t: Traffic, among: Ints) -> tuple[Ints, Floats]:
    """Pairs of vehicles, or of a vehicle and a walker, whose boxes touch during the last step.

    Args:
        t: all vehicles.
        among: slots of those that are followed, rising; walkers are added.

    Returns:
        (n, 2) slots, the smaller first, in rising order, and (n,) instant of the first contact as a fraction of the
        step. For vehicles that jumped there is no motion to sweep: only the end of the step counts, and the instant
        is 1.
    """
    rows = np.append(among, t.walkers) if len(t.walkers) else among
    none = np.zeros((0, 2), np.int64), np.zeros(0)
    if len(rows) < 2:
        return none
    x, y, heading = t.x[rows], t.y[rows], t.heading[rows]
    dx, dy = x - t.old_x[rows], y - t.old_y[rows]
    end = Boxes.of(x, y, heading, t.length[rows], t.width[rows])
    reach = np.hypot(end.half_length, end.half_width) + np.hypot(dx, dy)
    turn = np.abs(np.sin(heading - t.old_heading[rows]))
    near = _may_have_touched(end.parts, len(among), reach, dx, dy, turn)
    if not near:
        return none
    pairs = np.sort(rows[np.array(near)], axis=1)
    return _first_contacts(t, pairs[np.lexsort(pairs.T[::-1])])


def _first_contacts(t: Traffic, pairs: Ints) -> tuple[Ints, Floats]:
    """Which of these pairs (n, 2) touch during the step, and when, as a fraction of it."""
    a, b = pairs.T
    when, samples = np.repeat(_SAMPLES, len(a)), len(_SAMPLES)
    one, two = (_boxes_at(t, np.tile(slots, samples), when) for slots in (a, b))
    inside = (separation(one, two) < 0).reshape(samples, -1)
    if not inside.any():
        return pairs[:0], when[:0]
    motion = ~(jumped(t, a) | jumped(t, b))
    inside[:-1] &= motion
    hit = inside.any(0)
    pairs, motion = pairs[hit], motion[hit]
    first = inside[:, hit].argmax(0)
    instant, before = _SAMPLES[first], _SAMPLES[np.maximum(first - 1, 0)]
    # Who touched before the step began, or jumped, has no instant to look for.
    k = (motion & (first > 0)).nonzero()[0]
    if len(k):
        (a, b), early, late = pairs[k].T, before[k], instant[k]
        for _ in range(_BISECTIONS):
            middle = (early + late) / 2
            met = separation(_boxes_at(t, a, middle), _boxes_at(t, b, middle)) < 0
            early, late = np.where(met, early, middle), np.where(met, middle, late)
        instant[k] = late
    return pairs, instant


@dataclass(frozen=True)
class Impact:
    """What happened at the instant of a contact.

    Attributes:
        time: instant [s].
        x, y: impact point, the centre of the touching surface [m].
        striker, struck: slots. The striker's front is at the impact point; if that is true of both or of neither, the
            striker is who brings more of the approach speed.
        striker_speed, struck_speed: at the instant [m/s].
        impact_speed: magnitude of the relative velocity [m/s].
        striker_delta_v, struck_delta_v: change of velocity if both go on together (plastic, central) [m/s].
        approach: speed at which the touching surfaces approach each other [m/s]; not positive is no impact.
        at_rear: the struck vehicle's rear bumper is at the impact point.
        angle: between the headings, 0 to pi [rad].
    """

    time: float
    x: float
    y: float
    striker: int
    struck: int
    striker_speed: float
    struck_speed: float
    impact_speed: float
    striker_delta_v: float
    struck_delta_v: float
    approach: float
    at_rear: bool
    angle: float


def impact(t: Traffic, pair: Ints, when: float, end_of_step: float) -> Impact:
    """The impact of a `pair` (2,) of slots a fraction `when` into the step that ended at `end_of_step` [s]."""
    boxes = _boxes_at(t, pair, when)
    speed = t.old_speed[pair] + (t.speed[pair] - t.old_speed[pair]) * when
    direction = np.column_stack([boxes.ux, boxes.uy])
    velocity = direction * speed[:, None]

    a, b = (Boxes(*(np.array([getattr(boxes, f)[i]]) for f in Boxes.__dataclass_fields__)) for i in (0, 1))
    between = np.array([boxes.cx[1] - boxes.cx[0], boxes.cy[1] - boxes.cy[0]])
    if jumped(t, pair).any():  # deep inside each other from the first: the axis of least depth means nothing
        normal = between / max(float(np.hypot(*between)), 1e-9)
    else:
        normal = np.array(_widest_gap(a.parts, 0, b.parts, 0)[1:])
    normal = normal if normal @ between >= 0 else -normal  # from the first to the second

    point = _middle_of_overlap(boxes)
    local = boxes.local(np.array([point, point]))[:, 0]
    with_front = local >= boxes.half_length - _FACE
    brings = np.array([velocity[0] @ normal, -(velocity[1] @ normal)])
    first = int(np.argmax(brings)) if with_front[0] == with_front[1] else int(np.argmax(with_front))
    other = 1 - first

    common = (t.mass[pair] @ velocity) / t.mass[pair].sum()
    delta_v = np.hypot(*(common - velocity).T)
    return Impact(
        time=end_of_step - (1 - when) * t.dt,
        x=float(point[0]),
        y=float(point[1]),
        striker=int(pair[first]),
        struck=int(pair[other]),
        striker_speed=float(speed[first]),
        struck_speed=float(speed[other]),
        impact_speed=float(np.hypot(*(velocity[0] - velocity[1]))),
        striker_delta_v=float(delta_v[first]),
        struck_delta_v=float(delta_v[other]),
        approach=float(brings.sum()),
        at_rear=bool(local[other] <= -boxes.half_length[other] + _FACE),
        angle=float(np.arccos(np.clip(direction[0] @ direction[1], -1.0, 1.0))),
    )


def _middle_of_overlap(boxes: Boxes, skin: float = 0.02) -> Floats:
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
