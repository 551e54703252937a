"""Which interventions get a verdict."""

import re
from dataclasses import dataclass, field

import numpy as np

from aeb_sumo.drivers.streams import stream
from aeb_sumo.errors import InputError

__all__ = ["Choice", "Reservoir"]


@dataclass(frozen=True)
class Choice:
    """All interventions, none of them, or a sample.

    Attributes:
        size: of the sample per run; 0 for none, inf for all.
    """

    size: float = 0

    @classmethod
    def parse(cls, text: str) -> "Choice":
        """From `all`, `none` or `sample:N`.

        Raises:
            InputError: it is none of these.
        """
        named = {"all": np.inf, "none": 0.0}
        sample = re.fullmatch(r"sample:([1-9]\d{0,8})", text.strip())
        if text not in named and sample is None:
            raise InputError(f"verdicts must be all, none or sample:N with N of 1 or more, not {text!r}")
        return cls(float(sample[1]) if sample else named[text])


@dataclass
class Reservoir:
    """A uniform random sample of things that come one by one (Vitter 1985, algorithm R).

    Each that comes takes a place, and may later lose it to another: which one, is drawn from the run's own stream.
    """

    size: float
    seed: int
    _seen: int = 0
    _places: list[int] = field(default_factory=list)

    def offer(self) -> tuple[bool, int | None]:
        """The next thing comes: whether it gets a place, and the number (from 0) of the one that loses its own."""
        number, self._seen = self._seen, self._seen + 1
        if np.isinf(self.size):
            return True, None
        if len(self._places) < self.size:
            self._places.append(number)
            return True, None
        place = int(stream(self.seed, "verdicts", str(number)).integers(self._seen))
        if place >= self.size:
            return False, None
        loser, self._places[place] = self._places[place], number
        return True, loser
