"""Errors of encounters: who fails to give way, who rides against the signal, who reacts to a warning.

Every draw belongs to one road user and one encounter.
"""

from dataclasses import dataclass

import numpy as np

from aeb_sumo.drivers.streams import stream
from aeb_sumo.parameters import check, within

__all__ = ["FailureToYield", "Riders", "Warned", "lognormal"]


def lognormal(draw: np.random.Generator, *, mean: float, sd: float) -> float:
    """A log-normal draw with this mean and standard deviation (of the variable itself, not of its logarithm)."""
    if mean <= 0:
        return 0.0
    variance = np.log1p((sd / mean) ** 2)
    return float(draw.lognormal(np.log(mean) - variance / 2, np.sqrt(variance)))


@dataclass(frozen=True, kw_only=True)
class FailureToYield:
    """Drivers who have to give way and do not: because they do not look, or because they cannot see.

    An encounter is one driver's passage of a junction against those who come from one approach, two-wheelers and
    others apart: who does not look for e-bikes overlooks all of them.

    Attributes:
        probability: that a driver does not look for two-wheelers, our assumption: far more often than in life, so that
            a short run has conflicts.
        right_turn: the same of one who turns right, our assumption: he has seen those beside him before.
        motor: that he does not look for motor vehicles, our assumption.
        rider_unaware: that a rider whom such a driver overlooks relies on the right of way and does not react to the
            moving car, one draw per driver and rider, our assumption.
        notice_mean, notice_sd: of the log-normal time from when another is in sight to when a driver who looks has
            noticed him, and of a rider's reaction to a car that stands in his way [s]; 0.92 and 0.28 from another
            source (reaction to a crossing conflict, de Gelder, V in evidence.md).
        occlusion: drivers see nobody behind other vehicles or buildings; false is a world of glass, our assumption.
    """

    name = "failure_to_yield"
    probability: float = within(0.5, 0.0, 1.0)
    right_turn: float = within(0.1, 0.0, 1.0)
    motor: float = within(0.0, 0.0, 1.0)
    rider_unaware: float = within(0.5, 0.0, 1.0)
    notice_mean: float = within(0.92, 0.0, 60.0)
    notice_sd: float = within(0.28, 0.0, 60.0)
    occlusion: bool = True

    def __post_init__(self) -> None:
        """Raises `InputError` for a parameter out of range."""
        check(self)

    def driver_fails(
        self, seed: int, driver: str, junction: str, approach: str, *, rider: bool, right_turn: bool = False
    ) -> bool:
        """Whether this driver does not look for those who come from this approach to this junction."""
        kind, limit = (
            ("riders", self.right_turn if right_turn else self.probability) if rider else ("motor", self.motor)
        )
        return bool(stream(seed, self.name, driver, junction, approach, kind).random() < limit)

    def rider_fails(self, seed: int, driver: str, rider: str) -> bool:
        """Whether this rider does not react to this driver."""
        return bool(stream(seed, self.name, driver, "rider", rider).random() < self.rider_unaware)

    def notice(self, seed: int, who: str, whom: str) -> float:
        """How long it takes to notice one who has come in sight [s]."""
        return lognormal(stream(seed, "notice", who, whom), mean=self.notice_mean, sd=self.notice_sd)


@dataclass(frozen=True, kw_only=True)
class Riders:
    """Violations of riders of two-wheelers: one draw per rider and junction.

    Riding against the lane is a matter of routes, and so of demand.

    Attributes:
        red_light: probability that a rider does not stop at red, our assumption. (Violations of riders were behind
            about 90 % of the e-bike crashes at junctions in Shanghai: evidence.md, S.)
    """

    name = "red_light"
    red_light: float = within(0.1, 0.0, 1.0)

    def __post_init__(self) -> None:
        """Raises `InputError` for a parameter out of range."""
        check(self)

    def runs_red(self, seed: int, rider: str, junction: str) -> bool:
        """Whether this rider does not stop at this junction's red."""
        return bool(stream(seed, self.name, rider, junction).random() < self.red_light)


@dataclass(frozen=True, kw_only=True)
class Warned:
    """What a driver does when his AEB warns him: he looks, sees what he is warned of, and brakes if he has to.

    Attributes:
        responds: probability that a warning reaches him, one draw per driver and target, our assumption.
        delay_mean, delay_sd: of the log-normal time from the warning to his eyes on the road and his foot on the brake
            [s], our assumption. In an emergency he brakes then at the latest, as hard as he would have done later, and
            also if without the warning he would not have braked at all.
        attention: for how long after a warning he keeps his eyes on the road [s], our assumption.
    """

    name = "warned"
    responds: float = within(0.9, 0.0, 1.0)
    delay_mean: float = within(0.6, 0.0, 60.0)
    delay_sd: float = within(0.2, 0.0, 60.0)
    attention: float = within(3.0, 0.0, 600.0)

    def __post_init__(self) -> None:
        """Raises `InputError` for a parameter out of range."""
        check(self)

    def delay(self, seed: int, driver: str, target: str) -> float:
        """From the warning to the eyes on the road [s]; `inf` for one whom it does not reach."""
        draw = stream(seed, self.name, driver, target)
        reached = draw.random() < self.responds
        delay = lognormal(draw, mean=self.delay_mean, sd=self.delay_sd)
        return delay if reached else np.inf
