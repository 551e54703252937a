"""An event, filmed in both worlds."""

from dataclasses import dataclass
from math import isnan, nan

from aeb_sumo.replay.director import World
from aeb_sumo.replay.event import Event
from aeb_sumo.verdicts.judge import verdict

__all__ = ["Take"]


@dataclass(frozen=True, kw_only=True)
class Take:
    """An event, filmed.

    Attributes:
        event: as in the tables.
        forked: when the other world was made [s].
        factual: the world as it was.
        other: the other world; None: there is none.
        reason: why; else empty.
    """

    event: Event
    forked: float
    factual: World
    other: World | None
    reason: str = ""

    @property
    def worlds(self) -> list[World]:
        """Those that there are."""
        return [self.factual, *([] if self.other is None else [self.other])]

    @property
    def parting(self) -> float:
        """From when on the two worlds differ [s]: when the intervention first acts on this one, if that is known."""
        acted = nan if self.event.intervention is None else float(self.event.intervention["acted_s"])
        return self.forked if isnan(acted) else acted

    @property
    def partner(self) -> str:
        """Whom the film is about beside the ego: whom it crashes with in either world, else the other of the event.

        A system may have been aiming at another than the one who would have been hit.
        """
        if self.event.kind == "intervention":
            for contact in (c for world in self.worlds for c in world.film.contacts):
                if self.event.ego in (contact.striker, contact.struck):
                    return contact.struck if contact.striker == self.event.ego else contact.striker
        return self.event.other

    @property
    def verdict(self) -> str:
        """What the AEB was, or would have been, worth, by these two worlds; empty without the other."""
        if self.other is None:
            return ""
        with_, without = self.factual.outcome, self.other.outcome
        if self.event.intervention is None:
            with_, without = without, with_
        return verdict(with_, without)
