"""Pairs of vehicles that meet in a step, one behind the other or where their paths cross, and how critical that is."""

from dataclasses import dataclass

import numpy as np

from aeb_sumo.criticality import crossing_ttc, drac, required_decel, ttc, ttc2, yielding_decel
from aeb_sumo.perception.lead import truly_ahead
from aeb_sumo.soa import Bools, Floats, Ints
from aeb_sumo.world.contact import Boxes, distance
from aeb_sumo.world.leads import Leads
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.paths import Crossings

__all__ = ["THREAT", "Pairs", "crossing", "following"]

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


def _keys(t: Traffic, slots: Ints) -> Ints:
    serial = t.serial[slots].astype(np.int64)
    return serial[:, 0] * 2**32 + serial[:, 1]


def following(t: Traffic, leads: Leads, wrecked: Bools, *, among: Ints | None = None) -> Pairs:
    """Vehicles that closed in on the one ahead in the last step, at its begin or at its end; `among` these slots only.

    With whom no conflict is possible (see `Leads`) is not asked.

    A lead that SUMO names counts when it is truly there (see `perception.lead.truly_ahead`) and in the way: on the arc
    from the ego's heading to its own, give or take the bodies' widths.
    """
    ego = leads.egos if among is None else leads.egos[np.isin(leads.egos, among)]
    ego = ego[~wrecked[ego]]
    lead = leads.lead[ego]
    nears = ((t.speed[ego] > t.speed[lead]) | (t.old_speed[ego] > t.old_speed[lead])).nonzero()[0]
    ego, lead = ego[nears], lead[nears]
    gap, heading = leads.gap[ego], t.heading[ego]
    rear_x, rear_y = t.rear(lead)
    dx, dy, turned = rear_x - t.x[ego], rear_y - t.y[ego], t.heading[lead] - heading
    along = heading + ((turned + np.pi) % (2 * np.pi) - np.pi) / 2
    aside = np.abs(dy * np.cos(along) - dx * np.sin(along))
    there = truly_ahead(distance=np.hypot(dx, dy), gap=gap, turned=turned)
    k = (there & (aside < (t.width[ego] + t.width[lead]) / 2 + _ASIDE * np.maximum(gap, 0.0))).nonzero()[0]
    ego, lead, gap = ego[k], lead[k], gap[k]
    slots = np.array([ego, lead]).T
    speed, lead_speed, lead_accel = t.speed[ego], t.speed[lead], t.accel[lead]
    closing = speed - lead_speed
    time = ttc(gap=gap, closing_speed=closing)
    return Pairs(
        key=_keys(t, slots),
        slots=slots,
        second=np.zeros(len(k), np.int64),
        threat=time < THREAT,
        gap=gap,
        ttc=time,
        ttc2=ttc2(gap=gap, closing_speed=closing, closing_accel=t.accel[ego] - lead_accel),
        drac=drac(gap=gap, closing_speed=closing),
        required=required_decel(gap=gap, speed=speed, lead_speed=lead_speed, lead_accel=lead_accel),
        zone=np.full((len(k), 4), np.nan),
    )


def crossing(t: Traffic, crossings: Crossings, wrecked: Bools) -> Pairs:
    """Vehicles whose paths cross, both there soon and neither gone yet.

    Once both are where the paths cross there is no time to collision any more: it is their distance that tells.
    """
    a, b, zone = crossings.ego, crossings.other, crossings.zone
    pace_a, pace_b = np.maximum(t.speed[a], _CREEP), np.maximum(t.speed[b], _CREEP)
    k = (
        (t.serial[a] < t.serial[b])
        & (zone[:, 0] < _SOON * pace_a)
        & (zone[:, 2] < _SOON * pace_b)
        & (zone[:, 1] + t.length[a] > 0)
        & (zone[:, 3] + t.length[b] > 0)
        & ~(wrecked[a] & wrecked[b])
    ).nonzero()[0]
    slots, zone = np.array([a[k], b[k]]).T, zone[k]
    to_zone, out = zone[:, ::2], zone[:, 1::2] + t.length[slots]
    speed, accel = t.speed[slots], t.accel[slots]
    enter, leave = ttc(gap=to_zone, closing_speed=speed), ttc(gap=out, closing_speed=speed)
    enter2 = ttc2(gap=to_zone, closing_speed=speed, closing_accel=accel)
    leave2 = ttc2(gap=out, closing_speed=speed, closing_accel=accel)
    inside = (to_zone <= 0).all(1)
    second = np.argmax(enter, 1)
    row, first = np.arange(len(k)), 1 - second

    def meeting(enter: Floats, leave: Floats) -> tuple[Floats, Floats]:
        """Time to collision, and deceleration that the second needs to let the first out."""
        time = crossing_ttc(enter=enter[:, 0], leave=leave[:, 0], other_enter=enter[:, 1], other_leave=leave[:, 1])
        time = np.where(inside, np.inf, time)
        need = yielding_decel(distance=to_zone[row, second], speed=speed[row, second], until=leave[row, first])
        return time, np.where(np.isfinite(time), need, 0.0)

    (time, need), (time2, need2) = meeting(enter, leave), meeting(enter2, leave2)
    one, two = (Boxes.of(*(q[s] for q in (t.x, t.y, t.heading, t.length, t.width))) for s in slots.T)
    return Pairs(
        key=-_keys(t, slots),
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
