"""What a scenario is."""

from dataclasses import dataclass, field

import sumo_nets
from aeb_sumo.drivers.profile import Profile
from aeb_sumo.errors import InputError
from aeb_sumo.world.friction import MU_RANGE, Stretch

__all__ = ["Scenario", "on_network"]


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """What is simulated; the AEB is not part of it.

    Attributes:
        name: for the tables.
        options: SUMO options: the inputs, and whatever else the scenario wants.
        drivers: what its drivers and riders do wrong.
        mu: friction coefficient of the road; 0.85 dry asphalt, from another source (Zhao et al. 2025, 3.1).
        stretches: pieces of road that have another.
        routes: content of a SUMO route file, for scenarios that bring their vehicles as text; empty for none.
        seed: of SUMO and of the drivers; None leaves SUMO's own default or what `options` say.
        step_length: [s]; None leaves it to `options`.
        duration: [s]; None runs until the end that `options` set, or until all vehicles have arrived.
        output_prefix: what the scenario puts before the names of SUMO's own output files.
    """

    name: str
    options: tuple[str, ...]
    drivers: Profile = field(default_factory=Profile)
    mu: float = 0.85
    stretches: tuple[Stretch, ...] = ()
    routes: str = ""
    seed: int | None = 1
    step_length: float | None = 0.1
    duration: float | None = 600.0
    output_prefix: str = ""

    def __post_init__(self) -> None:
        """Raises `InputError` for a friction that no road has."""
        if not MU_RANGE[0] <= self.mu <= MU_RANGE[1]:
            raise InputError("friction of {} must be within {} .. {}, not {:g}".format(self.name, *MU_RANGE, self.mu))


def on_network(name: str) -> tuple[str, ...]:
    """SUMO options for one of the networks of `sumo_nets` and the traffic that lies beside it."""
    folder = sumo_nets.folder(name)
    return ("--net-file", str(folder / f"{name}.net.xml"), "--route-files", str(folder / f"{name}.rou.xml"))
