"""Pairs of vehicles that meet in a step, one behind the other or where their paths cross, and how critical that is."""

from dataclasses import dataclass

import numpy as np

from aeb_sumo.compiled import kernel
from aeb_sumo.criticality import crossing_ttc, drac, required_decel, ttc, ttc2, yielding_decel
from aeb_sumo.perception.lead import truly_ahead
from aeb_sumo.soa import Bools, Floats, Ints
from aeb_sumo.world.boxes import Boxes, distance
from aeb_sumo.world.leads import Leads
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.paths import Crossings

__all__ = ["NOBODY", "THREAT", "Pairs", "crossing", "following"]

THREAT = 4.0
"""TTC below which hard braking is taken for evasive [s], from another source: the trigger of the 100-Car study (Dingus
et al. 2006: 0.5 g at a forward TTC of 4 s or less; remembered, not read again)."""

_SOON = 5.0  # s before a crossing, at the present speed, from which a pair is followed, our assumption
_CREEP = 3.0  # m/s, what those that stand count as there: they may set off, our assumption
_ASIDE = 0.05  # per m of distance, how much farther aside a lead may be than the bodies are wide, our assumption


@dataclass(frozen=True, kw_only=True)
class Pairs:
    """Pairs of one step, (k,) each.

    Attributes:
        key: tells a pair from others, also from step to step; negative at crossings.
        slots: (k, 2) the ego and its lead; at crossings the earlier in the run first.
        second: column of `slots` of who would come second; 0 for followers.
        threat: their TTC is below `THREAT`, or both are where their paths cross.
        gap: bumper to bumper; at crossings distance of the bodies [m].
        ttc, ttc2: [s].
        drac, required: decelerations that the second needs [m/s2].
        zone: (k, 4) first column's distances to where the crossing begins and ends, then the second's [m]; nan for
            followers.
    """

    key: Ints
    slots: Ints
    second: Ints
    threat: Bools
    gap: Floats
    ttc: Floats
    ttc2: Floats
    drac: Floats
    required: Floats
    zone: Floats


_NONE: Ints = np.zeros(0, np.int64)
_NOTHING = np.zeros(0)
NOBODY = Pairs(
    key=_NONE,
    slots=np.zeros((0, 2), np.int64),
    second=_NONE,
    threat=np.zeros(0, np.bool_),
    gap=_NOTHING,
    ttc=_NOTHING,
    ttc2=_NOTHING,
    drac=_NOTHING,
    required=_NOTHING,
    zone=np.zeros((0, 4)),
)
"""No pairs."""


def following(t: Traffic, leads: Leads, wrecked: Bools, *, among: Ints | None = None) -> Pairs:
    """Vehicles that closed in on the one ahead in the last step, at its begin or at its end; `among` these slots only.

    With whom no conflict is possible (see `Leads`) is not asked.

    A lead that SUMO names counts when it is truly there (see `perception.lead.truly_ahead`) and in the way: on the arc
    from the ego's heading to its own, give or take the bodies' widths.
    """
    egos = leads.egos if among is None else leads.egos[np.isin(leads.egos, among)]
    slots, gap, angles = _closing_in(egos, leads.lead, leads.gap, wrecked, t.speed, t.old_speed, t.heading)
    if not len(slots):
        return NOBODY
    dx, dy, inline = _in_line(slots, gap, np.cos(angles[:2]), np.sin(angles[:2]), t.x, t.y, t.length, t.width)
    there = inline & truly_ahead(distance=np.hypot(dx, dy), gap=gap, turned=angles[2])
    if not there.all():
        slots, gap = slots[there], gap[there]
    key, speed, lead_speed, lead_accel, closing, faster = _motion(slots, t.serial, t.speed, t.accel)
    time = ttc(gap=gap, closing_speed=closing)
    return Pairs(
        key=key,
        slots=slots,
        second=np.zeros(len(slots), np.int64),
        threat=time < THREAT,
        gap=gap,
        ttc=time,
        ttc2=ttc2(gap=gap, closing_speed=closing, closing_accel=faster),
        drac=drac(gap=gap, closing_speed=closing),
        required=required_decel(gap=gap, speed=speed, lead_speed=lead_speed, lead_accel=lead_accel),
        zone=np.full((len(slots), 4), np.nan),
    )


@kernel
def _closing_in(
    egos: Ints, leads: Ints, gaps: Floats, wrecked: Bools, speed: Floats, old_speed: Floats, heading: Floats
) -> tuple[Ints, Floats, Floats]:
    """(k, 2) slots of egos and leads, (k,) gaps, and (3, k) lead's heading, middle of the arc to it, and turn [rad]."""
    slots, gap, angles = np.empty((len(egos), 2), np.int64), np.empty(len(egos)), np.empty((3, len(egos)))
    k = 0
    for ego in egos:
        lead = leads[ego]
        if wrecked[ego] or not (speed[ego] > speed[lead] or old_speed[ego] > old_speed[lead]):
            continue
        turned = heading[lead] - heading[ego]
        slots[k, 0], slots[k, 1], gap[k] = ego, lead, gaps[ego]
        angles[0, k], angles[2, k] = heading[lead], turned
        angles[1, k] = heading[ego] + ((turned + np.pi) % (2 * np.pi) - np.pi) / 2
        k += 1
    return slots[:k], gap[:k], angles[:, :k].copy()


@kernel
def _in_line(
    slots: Ints, gap: Floats, cos: Floats, sin: Floats, x: Floats, y: Floats, length: Floats, width: Floats
) -> tuple[Floats, Floats, Bools]:
    """(k,) ways from front to rear bumper [m], and whether the lead is not aside; by the sines of `_closing_in`."""
    dx, dy, inline = np.empty(len(slots)), np.empty(len(slots)), np.empty(len(slots), np.bool_)
    for k in range(len(slots)):
        ego, lead = slots[k]
        dx[k] = x[lead] - length[lead] * cos[0, k] - x[ego]
        dy[k] = y[lead] - length[lead] * sin[0, k] - y[ego]
        aside = np.abs(dy[k] * cos[1, k] - dx[k] * sin[1, k])
        inline[k] = aside < (width[ego] + width[lead]) / 2 + _ASIDE * np.maximum(gap[k], 0.0)
    return dx, dy, inline


@kernel
def _key(one: float, other: float) -> int:
    return np.int64(one) * 2**32 + np.int64(other)  # type: ignore[return-value]


@kernel
def _motion(
    slots: Ints, serial: Floats, speed: Floats, accel: Floats
) -> tuple[Ints, Floats, Floats, Floats, Floats, Floats]:
    """Per pair: key, speeds, acceleration of the lead, how fast the ego closes in, and faster and faster."""
    n = len(slots)
    key, own, ahead, closing = np.empty(n, np.int64), np.empty(n), np.empty(n), np.empty(n)
    faster, lead_accel = np.empty(n), np.empty(n)
    for k in range(n):
        ego, lead = slots[k]
        key[k] = _key(serial[ego], serial[lead])
        own[k], ahead[k], lead_accel[k] = speed[ego], speed[lead], accel[lead]
        closing[k], faster[k] = speed[ego] - speed[lead], accel[ego] - accel[lead]
    return key, own, ahead, lead_accel, closing, faster


def crossing(t: Traffic, crossings: Crossings, wrecked: Bools) -> Pairs:
    """Vehicles whose paths cross, both there soon and neither gone yet.

    Once both are where the paths cross there is no time to collision any more: it is their distance that tells.
    """
    key, slots, zone, to_zone, out, speed, accel = _soon(
        crossings.ego, crossings.other, crossings.zone, wrecked, t.serial, t.length, t.speed, t.accel
    )
    if not len(key):
        return NOBODY
    enter, leave = ttc(gap=to_zone, closing_speed=speed), ttc(gap=out, closing_speed=speed)
    enter2 = ttc2(gap=to_zone, closing_speed=speed, closing_accel=accel)
    leave2 = ttc2(gap=out, closing_speed=speed, closing_accel=accel)
    inside = (to_zone <= 0).all(1)
    second = np.argmax(enter, 1)
    row, first = np.arange(len(key)), 1 - second
    distance_of_second, speed_of_second = to_zone[row, second], speed[row, second]

    def meeting(enter: Floats, leave: Floats) -> tuple[Floats, Floats]:
        """Time to collision, and deceleration that the second needs to let the first out."""
        time = crossing_ttc(enter=enter[:, 0], leave=leave[:, 0], other_enter=enter[:, 1], other_leave=leave[:, 1])
        time = np.where(inside, np.inf, time)
        need = yielding_decel(distance=distance_of_second, speed=speed_of_second, until=leave[row, first])
        return time, np.where(np.isfinite(time), need, 0.0)

    (time, need), (time2, need2) = meeting(enter, leave), meeting(enter2, leave2)
    one, two = (Boxes.of(*(q[s] for q in (t.x, t.y, t.heading, t.length, t.width))) for s in slots.T)
    return Pairs(
        key=key,
        slots=slots,
        second=second,
        threat=(time < THREAT) | inside,
        gap=distance(one, two),
        ttc=time,
        ttc2=time2,
        drac=need,
        required=need2,
        zone=zone,
    )


@kernel
def _soon(
    ego: Ints,
    other: Ints,
    zones: Floats,
    wrecked: Bools,
    serial: Floats,
    length: Floats,
    speed: Floats,
    accel: Floats,
) -> tuple[Ints, Ints, Floats, Floats, Floats, Floats, Floats]:
    """Of crossings (n,) those that matter: key, slots, zone as in `Pairs`, (k, 2) ways in and out, and motion."""
    rows = np.empty(len(ego), np.int64)
    n = 0
    for k in range(len(ego)):
        a, b = ego[k], other[k]
        if (
            serial[a] < serial[b]
            and zones[k, 0] < _SOON * max(speed[a], _CREEP)
            and zones[k, 2] < _SOON * max(speed[b], _CREEP)
            and zones[k, 1] + length[a] > 0
            and zones[k, 3] + length[b] > 0
            and not (wrecked[a] and wrecked[b])
        ):
            rows[n] = k
            n += 1
    key, slots, zone = np.empty(n, np.int64), np.empty((n, 2), np.int64), zones[rows[:n]]
    to_zone, out, speeds, accels = np.empty((n, 2)), np.empty((n, 2)), np.empty((n, 2)), np.empty((n, 2))
    for k in range(n):
        slots[k, 0], slots[k, 1] = ego[rows[k]], other[rows[k]]
        key[k] = -_key(serial[slots[k, 0]], serial[slots[k, 1]])
        for column in range(2):
            slot = slots[k, column]
            to_zone[k, column], out[k, column] = zone[k, 2 * column], zone[k, 2 * column + 1] + length[slot]
            speeds[k, column], accels[k, column] = speed[slot], accel[slot]
    return key, slots, zone, to_zone, out, speeds, accels
