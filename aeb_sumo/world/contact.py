"""Contact of vehicles as oriented boxes, swept over a step.

A crash is a contact: the boxes of two vehicles touch while they approach each other. SUMO's own test looks along a lane
(or at shapes inside a junction), at the end of a step, and calls either vehicle the collider.
"""

from dataclasses import dataclass

import numpy as np

from aeb_sumo.soa import Bools, Floats, Ints
from aeb_sumo.world.boxes import Boxes, may_have_touched, middle_of_overlap, parting_axis, separation
from aeb_sumo.world.observe import Traffic

__all__ = ["Impact", "impact", "touching"]

_SAMPLES = np.linspace(0.0, 1.0, 9)  # of a step, for vehicles that may pass each other within it
_BISECTIONS = 20  # 0.1 s / 8 / 2^20: below a microsecond
_FACE = 0.3  # m: how near to a bumper a contact counts as one on that bumper


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
    near = may_have_touched(end.parts, len(among), reach, dx, dy, turn)
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
    # Who jumped is deep inside the other from the first: the axis of least depth means nothing.
    straight = between / max(float(np.hypot(*between)), 1e-9)
    normal = straight if jumped(t, pair).any() else parting_axis(a, b)
    normal = normal if normal @ between >= 0 else -normal  # from the first to the second

    point = middle_of_overlap(boxes)
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
