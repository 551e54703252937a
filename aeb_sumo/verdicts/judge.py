"""Two worlds compared: what an intervention was worth. Pure functions."""

from dataclasses import dataclass
from math import inf

from aeb_sumo.severity import SAME_IMPACT

__all__ = ["Hit", "Outcome", "verdict"]

_CLOSE = 1.0  # s, PET below which a crossing is a close call though nobody braked, our assumption


@dataclass(frozen=True)
class Hit:
    """One crash that counts for an intervention.

    Attributes:
        pair: names of the two, in alphabetical order.
        own: the vehicle that intervened is one of them; otherwise one behind it.
        impact_speed: magnitude of the relative velocity [m/s].
        delta_v: the larger change of velocity of the two [m/s].
        serious_risk: that somebody is injured seriously, summed over the two; None where no curve applies.
    """

    pair: tuple[str, str]
    own: bool
    impact_speed: float
    delta_v: float
    serious_risk: float | None


@dataclass(frozen=True)
class Outcome:
    """What happened to a vehicle and those behind it in a window of time.

    Attributes:
        hits: crashes, in the order of time.
        near_crash: its driver braked for somebody ahead as in a near-crash (table `conflicts`), or one of two people
            whose paths cross did; what an AEB brakes is no sign of danger and does not count.
        min_gap: smallest gap to whom it closed in on, or distance to whose path it crossed; inf for nobody [m].
        pet: smallest post-encroachment time of its crossings that were over; inf for none [s].
        follower_decel: largest deceleration of who followed close behind [m/s2].
    """

    hits: tuple[Hit, ...] = ()
    near_crash: bool = False
    min_gap: float = inf
    pet: float = inf
    follower_decel: float = 0.0

    @property
    def hardest(self) -> Hit | None:
        """The crash with the largest impact speed."""
        return max(self.hits, key=lambda hit: hit.impact_speed, default=None)


def verdict(with_: Outcome, without: Outcome) -> str:
    """What an intervention was worth: one of `aeb_sumo.results.VERDICTS`, all but unknown.

    A crash behind the vehicle that happens in both worlds, as hard in one as in the other, has nothing to do with the
    intervention and does not count.

    Args:
        with_: as it happened.
        without: without the intervention.
    """
    factual, otherwise = _concerned(with_.hits, without.hits), _concerned(without.hits, with_.hits)
    if factual and otherwise:
        return _compared(factual, otherwise)
    if factual or otherwise:
        return "induced" if factual else "avoided"
    return "precautionary" if without.near_crash or without.pet < _CLOSE else "unneeded"


def _compared(factual: list[Hit], otherwise: list[Hit]) -> str:
    hardest, before = (max(h.impact_speed for h in hits) for hits in (factual, otherwise))
    same = {h.pair for h in factual} == {h.pair for h in otherwise}
    alike = abs(hardest - before) <= SAME_IMPACT
    risk, risk_before = _risk(factual), _risk(otherwise)
    if risk is not None and risk_before is not None and not (same and alike):
        hardest, before, alike = risk, risk_before, risk == risk_before
    return "unchanged" if alike else "mitigated" if hardest < before else "worsened"


def _concerned(hits: tuple[Hit, ...], others: tuple[Hit, ...]) -> list[Hit]:
    """The crashes that are the vehicle's own, or that differ from those of the other world."""
    return [
        hit
        for hit in hits
        if hit.own
        or not any(o.pair == hit.pair and abs(o.impact_speed - hit.impact_speed) <= SAME_IMPACT for o in others)
    ]


def _risk(hits: list[Hit]) -> float | None:
    """Expected number of seriously injured; None where it is not known of every crash."""
    total = 0.0
    for hit in hits:
        if hit.serious_risk is None:
            return None
        total += hit.serious_risk
    return total
