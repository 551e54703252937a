"""Queues: who stands, stops, and waits behind a wreck; looked at once per second.

Definitions, over vehicles that are no wrecks. `share` is the share of the time since the last look that a vehicle has
lost against driving at the speed it would drive if it were alone (see `aeb_sumo.world.surroundings.Trips`); it is 0 at
a scheduled stop.

* It *stands* when it is slower than 5 km/h, but for scheduled stops. From another source: SUMO's lane area detectors.
* It *stops* when it comes to stand after having been faster than 10 km/h (our assumption), so that creeping on in a
  queue is no new stop.
* It is *queued* from when it drives at less than half the speed it would drive alone until it drives at more than 70 %
  of it, both our assumption.
* It is *blocked* from when it is queued and its leads, through queued ones, end in a wreck, until it is not queued any
  more: who has found a way round the wreck is blocked until he is up to speed again. Not seen are those who slow down
  beside a wreck, or for a queue on the lane beside, and those for whom SUMO names no lead within 150 m, as for a wreck
  across a junction; where there would be a queue anyway, all its delay counts while its leads end in a wreck.
"""

import numpy as np

from aeb_sumo.ledger.bottlenecks import Bottlenecks
from aeb_sumo.soa import Bools, Floats, Ints, fitted
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.surroundings import ahead

__all__ = ["Queues", "behind"]

_STANDS = 5 / 3.6  # m/s, from another source: default of SUMO's lane area detectors
_MOVES = 10 / 3.6  # m/s, our assumption
_QUEUED, _FREE = 0.5, 0.3  # shares of time lost above and below which a vehicle is queued and is not, our assumption


def behind(lead: Ints, *, through: Bools, wrecked: Bools) -> Bools:
    """Who waits behind a wreck.

    Args:
        lead: (n,) the vehicle ahead of each, -1 for none.
        through: (n,) vehicles that pass on that they are held up.
        wrecked: (n,) vehicles that are wrecks.

    Returns:
        (n,) True for those in `through` whose leads, and theirs, end in a wreck; False for wrecks.
    """
    end = np.arange(len(lead))
    onward = through & ~wrecked & (lead >= 0)
    end[onward] = lead[onward]
    for _ in range(len(lead).bit_length()):  # twice as far each time
        end = end[end]
    return onward & wrecked[end]


class Queues:
    """State of every vehicle, by its slot."""

    def __init__(self, traffic: Traffic) -> None:
        self._traffic = traffic
        self._moving: Bools = np.zeros(0, np.bool_)
        self._queued: Bools = np.zeros(0, np.bool_)
        self._blocked: Bools = np.zeros(0, np.bool_)
        self._bottlenecks = Bottlenecks(traffic)

    def depart(self, slot: int) -> None:
        """A vehicle enters."""
        self._fit()
        self._moving[slot] = self._queued[slot] = self._blocked[slot] = False
        self._bottlenecks.depart(slot)

    def look(self, time: float, speed: Floats, shares: Floats, wrecked: Bools) -> dict[str, Floats]:
        """Look at all vehicles present.

        Args:
            time: now [s].
            speed: (n,) of those present [m/s].
            shares: (n,) of the time since the last look that they have lost.
            wrecked: per slot.

        Returns:
            By column of table `traffic`, (n,) what each adds to it; durations as shares of the time since then.
        """
        self._fit()
        rows = self._traffic.present
        free = ~wrecked[rows]
        standing = free & (speed < _STANDS) & (shares > 0)
        stops = standing & self._moving[rows]
        self._moving[rows] = (self._moving[rows] & (speed >= _STANDS)) | (speed > _MOVES)
        queued = free & (shares > np.where(self._queued[rows], _FREE, _QUEUED))
        self._queued[rows] = queued
        headway = self._bottlenecks.look(time, self._queued)
        result = {
            "standing_s": standing.astype(float),
            "stops": stops.astype(float),
            "blocked_s": self._are_blocked(wrecked)[rows] * shares,
        }
        if headway:
            result["discharged"] = np.isin(rows, list(headway)).astype(float)
            result["headway_s"] = np.array([headway.get(slot, 0.0) for slot in rows.tolist()])
        return result

    def _are_blocked(self, wrecked: Bools) -> Bools:
        """Per slot."""
        t, rows = self._traffic, self._traffic.present
        self._blocked[rows] &= self._queued[rows]
        if wrecked[rows].any():
            slots = rows[self._queued[rows]]
            lead = np.full(t.capacity, -1)
            lead[slots] = ahead(t, slots)
            self._blocked |= behind(lead, through=self._queued, wrecked=wrecked)
        return self._blocked

    def _fit(self) -> None:
        n = self._traffic.capacity
        self._moving, self._queued, self._blocked = (
            fitted(state, n) for state in (self._moving, self._queued, self._blocked)
        )
