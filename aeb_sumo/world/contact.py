"""Contact of vehicles as oriented boxes, swept over a step; pure geometry.

A crash is a contact: the boxes of two vehicles touch while they approach each other. SUMO's own test looks along a lane
(or at shapes inside a junction), at the end of a step, and calls either vehicle the collider.
"""

from dataclasses import dataclass

import numpy as np

from aeb_sumo.soa import Bools, Floats, Ints, take
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

    def corners(self) -> Floats:
        """(n, 4, 2) corners, counter-clockwise from the front left [m]."""
        u = np.stack([self.ux, self.uy], -1) * self.half_length[:, None]
        w = np.stack([-self.uy, self.ux], -1) * self.half_width[:, None]
        c = np.stack([self.cx, self.cy], -1)
        return np.stack([c + u + w, c - u + w, c - u - w, c + u - w], 1)

    def local(self, point: Floats) -> Floats:
        """(n, 2) forward and left coordinates of points (n, 2) from the centre [m]."""
        dx, dy = point[:, 0] - self.cx, point[:, 1] - self.cy
        return np.stack([dx * self.ux + dy * self.uy, dy * self.ux - dx * self.uy], -1)


def _axes_gaps(a: Boxes, b: Boxes) -> Floats:
    """(4, n) gap along each box's two axes (a forward, a left, b forward, b left); all negative means overlap."""
    dx, dy = b.cx - a.cx, b.cy - a.cy
    cos = np.abs(a.ux * b.ux + a.uy * b.uy)
    sin = np.abs(a.ux * b.uy - a.uy * b.ux)
    return np.array(
        [
            np.abs(dx * a.ux + dy * a.uy) - (a.half_length + b.half_length * cos + b.half_width * sin),
            np.abs(dy * a.ux - dx * a.uy) - (a.half_width + b.half_length * sin + b.half_width * cos),
            np.abs(dx * b.ux + dy * b.uy) - (b.half_length + a.half_length * cos + a.half_width * sin),
            np.abs(dy * b.ux - dx * b.uy) - (b.half_width + a.half_length * sin + a.half_width * cos),
        ]
    )


def separation(a: Boxes, b: Boxes) -> Floats:
    """Largest gap along any axis of the two boxes, pairwise, (n,) [m].

    By the separating-axis theorem they overlap if and only if it is negative; its magnitude is then the smallest
    penetration. When positive it is a lower bound of the distance (exact face to face).
    """
    gaps: Floats = _axes_gaps(a, b).max(0)
    return gaps


def distance(a: Boxes, b: Boxes) -> Floats:
    """Distance of the two boxes, pairwise, (n,) [m]; 0 where they touch or overlap."""
    apart = np.minimum(_corners_to_sides(a.corners(), b.corners()), _corners_to_sides(b.corners(), a.corners()))
    return np.where(separation(a, b) <= 0, 0.0, apart)


def _corners_to_sides(corners: Floats, other: Floats) -> Floats:
    """Smallest distance from any of the corners (n, 4, 2) to any side of the other box, (n,) [m]."""
    (x, y), (start_x, start_y) = (np.moveaxis(c, -1, 0) for c in (corners, other))
    side_x, side_y = (np.concatenate([q[:, 1:], q[:, :1]], 1) - q for q in (start_x, start_y))
    to_x, to_y = x[:, :, None] - start_x[:, None, :], y[:, :, None] - start_y[:, None, :]
    side_x, side_y = side_x[:, None, :], side_y[:, None, :]
    share = (to_x * side_x + to_y * side_y) / (side_x**2 + side_y**2)
    share = np.minimum(np.maximum(share, 0.0), 1.0)
    off_x, off_y = to_x - share * side_x, to_y - share * side_y
    result: Floats = np.sqrt((off_x**2 + off_y**2).min(axis=(1, 2)))
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


def _within_reach(x: Floats, y: Floats, reach: Floats) -> tuple[Ints, Ints]:
    """Pairs, as rows, of those at (x, y) that are no farther apart than both their reaches [m]."""
    along = x if np.ptp(x) >= np.ptp(y) else y
    order = along.argsort()
    line = along[order]
    # Per row in order: how many of those behind it on the line are near enough on the line.
    rows = np.arange(len(line))
    many = line.searchsorted(line + 2 * reach.max(), side="right") - rows - 1
    first = rows.repeat(many)
    second = first + 1 + np.arange(len(first)) - (many.cumsum() - many).repeat(many)
    i, j = order[first], order[second]
    dx, dy, reach = x[i] - x[j], y[i] - y[j], reach[i] + reach[j]
    near = (dx * dx + dy * dy <= reach * reach).nonzero()[0]
    return i[near], j[near]


def _may_have_touched(a: Boxes, b: Boxes, *, dx: Floats, dy: Floats, turned: Floats) -> Bools:
    """Which boxes, where they are at the end of the step, may have touched during it.

    They touch at its end, or their relative motion (dx, dy) along the axis that parts them then, and what their turning
    moved their ends [m], was longer than the gap left.
    """
    gaps = _axes_gaps(a, b)
    axis = gaps.argmax(0)
    of_a, forward = axis < 2, axis % 2 == 0
    ux, uy = np.where(of_a, a.ux, b.ux), np.where(of_a, a.uy, b.uy)
    nx, ny = np.where(forward, ux, -uy), np.where(forward, uy, ux)
    result: Bools = gaps.max(0) < np.abs(dx * nx + dy * ny) + turned
    return result


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
    x, y, heading, length = t.x[rows], t.y[rows], t.heading[rows], t.length[rows]
    dx, dy = x - t.old_x[rows], y - t.old_y[rows]
    end = Boxes.of(x, y, heading, length, t.width[rows])
    i, j = _within_reach(end.cx, end.cy, np.hypot(end.half_length, end.half_width) + np.hypot(dx, dy))
    if len(t.walkers):
        i, j = (k[np.minimum(i, j) < len(among)] for k in (i, j))
    if not len(i):
        return none
    turn = np.abs(np.sin(heading - t.old_heading[rows]))
    near = _may_have_touched(
        take(end, i),
        take(end, j),
        dx=dx[i] - dx[j],
        dy=dy[i] - dy[j],
        turned=(turn[i] + turn[j]) * (length[i] + length[j]),
    )
    if not near.any():
        return none
    pairs = np.sort(np.column_stack([rows[i[near]], rows[j[near]]]), axis=1)
    return _first_contacts(t, pairs[np.lexsort(pairs.T[::-1])])


def _first_contacts(t: Traffic, pairs: Ints) -> tuple[Ints, Floats]:
    """Which of these pairs (n, 2) touch during the step, and when, as a fraction of it."""
    a, b = pairs.T
    motion = ~(jumped(t, a) | jumped(t, b))
    when = _SAMPLES[:, None]
    inside = separation(_boxes_at(t, a, when), _boxes_at(t, b, when)) < 0
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
        axis = int(_axes_gaps(a, b)[:, 0].argmax())
        owner = boxes.ux[axis // 2], boxes.uy[axis // 2]
        normal = np.array(owner if axis % 2 == 0 else (-owner[1], owner[0]))
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
