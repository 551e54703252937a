"""How drivers react to a vehicle ahead that they close in on: when they notice, when they brake, and how hard.

A driver notices when the looming of the vehicle ahead, the inverse of the time to collision, passes a threshold while
his eyes are on the road. What follows is drawn once per driver and vehicle ahead.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from aeb_sumo.drivers.classes import driver_classes, reaction_time
from aeb_sumo.errors import InputError
from aeb_sumo.parameters import check, within
from aeb_sumo.units import KMH, G

__all__ = ["MODELS", "Careful", "Looming", "Reaction", "Response", "Threat", "Zheng", "trucks"]


@dataclass(frozen=True, kw_only=True)
class Threat:
    """What there is to react to, at the instant it is noticed.

    Attributes:
        time_to_crash: until the crash if the driver does nothing [s].
        closing_speed: [m/s].
        late: the eyes came back to it when it was there already; else they were on the road when it arose.
    """

    time_to_crash: float
    closing_speed: float
    late: bool


@dataclass(frozen=True, kw_only=True)
class Response:
    """What a driver does about it.

    Attributes:
        delay: from noticing to braking [s], 0 or more; `inf`: he does not brake.
        jerk: how fast the deceleration builds up [m/s3] ...
        jerk_per_looming: ... and by how much more for every 1/s of looming at the onset of braking [m/s2].
        decel: that is reached [m/s2].
    """

    delay: float
    jerk: float = 0.0
    jerk_per_looming: float = 0.0
    decel: float


@dataclass(frozen=True, kw_only=True)
class Reaction(ABC):
    """A model of reactions.

    Attributes:
        looming: inverse time to collision from which a threat is noticed [1/s]; 0.2 from another source (Markkula et
            al. 2016).
        surprise: a vehicle ahead that brakes harder than this takes the driver behind by surprise: he goes on as he is
            until he notices [m/s2]; 0.5 g, our assumption: less is what SUMO's drivers expect of each other.
        mild: a threat that needs no more deceleration than this when it is noticed, from a vehicle ahead that does not
            brake hard, is no emergency: SUMO's driver does what is needed [m/s2]; our assumption. The published
            parameters are those of crashes and near-crashes.
    """

    model: ClassVar[str]
    sees_brake_lights: ClassVar[bool] = False
    """Notices at once a vehicle ahead that brakes hard; else its looming."""
    looming: float = 0.2
    surprise: float = 0.5 * G
    mild: float = 3.0

    def __post_init__(self) -> None:
        """Raises `InputError` for a parameter out of range."""
        check(self)

    @abstractmethod
    def respond(self, driver: np.random.Generator, encounter: np.random.Generator, threat: Threat) -> Response:
        """The response of a driver to a threat.

        Args:
            driver: stream of what belongs to the driver alone.
            encounter: stream of what belongs to this driver and this vehicle ahead.
            threat: what he notices.
        """


@dataclass(frozen=True, kw_only=True)
class Looming(Reaction):
    """Markkula et al. 2016, the authors' published parameters, SHRP2 cars (evidence.md, V); own defaults are printed.

    Noticed at an inverse TTC of 0.2 1/s; braking starts at `t02 + alpha (t_C - t02)`, where t_C is when the crash would
    happen without a response: alpha is normal when the eyes were on the threat and log-normal when they came back to it
    late; 1 or more means no braking, and less than 0 is 0, our assumption: who had reacted before would not be here.
    The jerk is `9.82 k / TTC` at the onset, k log-normal; the deceleration is normal.

    Attributes:
        alpha_mean, alpha_sd: of alpha with the eyes on the threat.
        late_mu, late_sigma: of ln alpha with the eyes coming back late.
        k_mu, k_sigma: of ln k.
        decel_mean, decel_sd: of the deceleration [m/s2].
    """

    model: ClassVar[str] = "looming"
    alpha_mean: float = 0.22
    alpha_sd: float = within(0.29, 0.0, 10.0)
    late_mu: float = within(-1.40, -20.0, 20.0)
    late_sigma: float = within(0.71, 0.0, 10.0)
    k_mu: float = within(1.23, -20.0, 20.0)
    k_sigma: float = within(0.62, 0.0, 10.0)
    decel_mean: float = 6.68
    decel_sd: float = 1.69

    def respond(self, driver: np.random.Generator, encounter: np.random.Generator, threat: Threat) -> Response:  # noqa: ARG002
        """See `Reaction.respond`."""
        normal = encounter.standard_normal(4)
        on, late = self.alpha_mean + self.alpha_sd * normal[0], np.exp(self.late_mu + self.late_sigma * normal[1])
        alpha = float(late if threat.late else on)
        return Response(
            delay=max(alpha, 0.0) * threat.time_to_crash if alpha < 1 else np.inf,
            jerk_per_looming=float(9.82 * np.exp(self.k_mu + self.k_sigma * normal[2])),
            decel=max(float(self.decel_mean + self.decel_sd * normal[3]), _LEAST),
        )


_LEAST = 1.0  # m/s2, our assumption: the tail of a normal distribution has no negative decelerations


def trucks() -> Looming:
    """`Looming` with the parameters of trucks (evidence.md, V)."""
    return Looming(
        alpha_mean=0.27, alpha_sd=0.40, late_mu=-0.51, late_sigma=0.85, k_mu=0.84, k_sigma=1.44, decel_mean=4.70,
        decel_sd=1.44,
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Careful(Reaction):
    """The careful reference driver of UN R157 (evidence.md, V); its own defaults are printed there.

    He reacts to a vehicle ahead that brakes hard; a cut-in or a slow vehicle is left to SUMO's driver, who reacts
    sooner than he would.

    Attributes:
        looming: risk is seen at a TTC of 2 s ...
        surprise: ... and in a vehicle ahead that brakes with 5 m/s2 or more (read in esmini's code, V).
        mild: everything is an emergency.
        delay: reaction time [s].
        decel: 0.774 g [m/s2].
        jerk: [m/s3].
    """

    model: ClassVar[str] = "careful"
    sees_brake_lights: ClassVar[bool] = True
    looming: float = 0.5
    surprise: float = 5.0
    mild: float = 0.0
    delay: float = 0.75
    decel: float = within(0.774 * G, 0.1, 15.0)
    jerk: float = within(12.65, 0.1, 1000.0)

    def respond(self, driver: np.random.Generator, encounter: np.random.Generator, threat: Threat) -> Response:  # noqa: ARG002
        """See `Reaction.respond`; nothing is drawn."""
        return Response(delay=self.delay, jerk=self.jerk, decel=self.decel)


@dataclass(frozen=True, kw_only=True)
class Zheng(Reaction):
    """The driver classes of Zheng et al. 2020: reaction time as a linear function of the closing speed.

    The lines are synthetic (`aeb_sumo.drivers.classes`); every driver is of one of the four classes.

    Attributes:
        share_1, share_2, share_3: of drivers of these classes; the rest is of class 4; equal shares are our assumption.
        decel_mean, decel_sd: of the deceleration [m/s2]; from another source (Markkula et al. 2016, as in `Looming`).
        jerk: [m/s3]; from another source (UN R157, as in `Careful`).
    """

    model: ClassVar[str] = "zheng2020"
    share_1: float = within(0.25, 0.0, 1.0)
    share_2: float = within(0.25, 0.0, 1.0)
    share_3: float = within(0.25, 0.0, 1.0)
    decel_mean: float = 6.68
    decel_sd: float = 1.69
    jerk: float = within(12.65, 0.1, 1000.0)

    def __post_init__(self) -> None:
        """Raises `InputError` for a parameter out of range, or shares that sum up to more than 1."""
        super().__post_init__()
        total = self.share_1 + self.share_2 + self.share_3
        if total > 1 + 1e-9:
            raise InputError(f"Zheng.share_1 + share_2 + share_3 must be 1 or less, not {total:g}")

    @cached_property
    def _upto(self) -> tuple[float, ...]:
        return tuple(np.cumsum([self.share_1, self.share_2, self.share_3]).tolist())

    def respond(self, driver: np.random.Generator, encounter: np.random.Generator, threat: Threat) -> Response:
        """See `Reaction.respond`."""
        cls = 1 + int(np.searchsorted(self._upto, driver.random(), side="right"))
        time = float(reaction_time(driver_classes(), cls, threat.closing_speed / KMH))
        decel = self.decel_mean + self.decel_sd * encounter.standard_normal()
        return Response(delay=time, jerk=self.jerk, decel=max(float(decel), _LEAST))


MODELS: dict[str, type[Reaction]] = {m.model: m for m in (Looming, Careful, Zheng)}
"""Models by name."""
