"""Ideal sensing: everything in view is seen as it is, and counts once it has been in view for a while."""

from dataclasses import dataclass

import numpy as np

from aeb_sumo.compiled import kernel
from aeb_sumo.perception.measurable import Measurable
from aeb_sumo.perception.noise import Keys
from aeb_sumo.soa import Bools, Floats

__all__ = ["UNSEEN", "Views", "seen_for"]

UNSEEN = -np.inf
"""Not in view: see `Views.seen`."""


@dataclass(frozen=True)
class Views:
    """Memory of an ideal suite, one row per pair of a vehicle and a target.

    Attributes:
        key: (n,) identity of the pair.
        seen: (n,) in view without a gap for so long [s]; -inf: not in view.
        confirmed: (n,) counts as a target.
    """

    key: Keys
    seen: Floats
    confirmed: Bools

    @property
    def watched(self) -> Bools:
        """(n,) there is something to judge: it is in view."""
        result: Bools = self.seen >= 0
        return result

    def motion(self, truth: Measurable, dt: float) -> Measurable:  # noqa: ARG002
        """What the vehicles take for true."""
        return truth


@kernel
def seen_for(seen: Floats, in_view: Bools, dt: float) -> Floats:
    """(n,) for how long targets have been in view, a step of `dt` [s] later; see `Views`."""
    result = np.full(len(seen), UNSEEN)
    for k in range(len(seen)):
        if in_view[k]:
            result[k] = seen[k] + dt if seen[k] >= 0 else 0.0
    return result
