"""What each equipped vehicle reacts to: one target, chosen among those that its sensors have confirmed."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from aeb_sumo.candidates import Pairs
from aeb_sumo.compiled import kernel
from aeb_sumo.perception.measurable import Measurable
from aeb_sumo.soa import Bools, Floats, Ints
from aeb_sumo.world.observe import Traffic

__all__ = ["Targets", "choose"]


@dataclass(frozen=True)
class Targets:
    """What each equipped vehicle reacts to, (n,) each, as its sensors tell it; see `Percept`.

    Attributes:
        slot: of the target, -1 for none.
        crossing: it crosses the own path.
    """

    slot: Ints
    crossing: Bools
    gap: Floats
    speed: Floats
    accel: Floats
    ahead: Floats
    left: Floats
    closing_ahead: Floats
    closing_left: Floats
    vulnerable: Bools

    @classmethod
    def none(cls, n: int) -> "Targets":
        """Nothing to react to, for `n` vehicles."""
        return cls(
            slot=np.full(n, -1, np.int64),
            crossing=np.zeros(n, np.bool_),
            gap=np.full(n, np.inf),
            speed=np.zeros(n),
            accel=np.zeros(n),
            ahead=np.full(n, np.inf),
            left=np.zeros(n),
            closing_ahead=np.zeros(n),
            closing_left=np.zeros(n),
            vulnerable=np.zeros(n, np.bool_),
        )


def choose(
    t: Traffic, pairs: Pairs, truth: Measurable, known: Measurable, rank: Floats, usable: Bools, *, waiting: bool
) -> tuple[Ints, Targets]:
    """For each vehicle the usable pair of the lowest rank; a lead before a crossing one of the same.

    Args:
        t: all vehicles.
        pairs: (k,) of a vehicle and another.
        truth: (k,) how they are to each other ...
        known: (k,) ... and how the vehicle knows it.
        rank: (k,) how near, in whatever unit the system goes by.
        usable: (k,) those to choose among.
        waiting: the systems know paths: they wait for crossing traffic at the crossing, where it stands in the way.

    Returns:
        (n,) slots of the vehicles that have a target, rising, and their targets.
    """
    ego, *values = _chosen(
        pairs.ego, pairs.other, pairs.crossing, pairs.gap, rank, usable, waiting, truth.distance,
        known.distance, known.left, known.closing, known.closing_accel, known.closing_left, t.speed, t.accel,
        t.vulnerable,
    )  # fmt: skip
    return ego, Targets(*values)


@kernel
def _chosen(
    ego: Ints, other: Ints, crossing: Bools, gap: Floats, rank: Floats, usable: Bools, waiting: bool, true: Floats,
    distance: Floats, left: Floats, closing: Floats, closing_accel: Floats, closing_left: Floats, speed: Floats,
    accel: Floats, vulnerable: Bools,
) -> tuple[Any, ...]:  # fmt: skip
    """Egos, rising, and the fields of their `Targets`."""
    chosen, n = np.empty(len(ego), np.int64), 0
    for k in np.argsort(ego, kind="mergesort"):
        if not usable[k]:
            continue
        best = chosen[n - 1] if n else -1
        if best < 0 or ego[best] != ego[k]:
            chosen[n] = k
            n += 1
        elif rank[k] < rank[best] or (rank[k] == rank[best] and crossing[best] and not crossing[k]):
            chosen[n - 1] = k
    k = chosen[:n]
    slots, slot, crosses, ahead = ego[k], other[k], crossing[k], distance[k]
    to, pace, change = ahead.copy(), speed[slots] - closing[k], accel[slots] - closing_accel[k]
    for i in range(n):
        if crosses[i] and waiting:
            to[i], pace[i], change[i] = max(gap[k[i]] + (ahead[i] - true[k[i]]), 0.0), 0.0, 0.0
    return slots, slot, crosses, to, pace, change, ahead, left[k], closing[k], closing_left[k], vulnerable[slot]
