"""What a scenario is."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

import sumo_nets
from aeb_sumo.drivers.profile import Profile
from aeb_sumo.errors import InputError
from aeb_sumo.registry import registered
from aeb_sumo.scenarios.demand import OPTIONS, Demand, routes
from aeb_sumo.world.friction import MU_RANGE, Stretch
from sumo_nets.intersection import Intersection

__all__ = ["WEATHER", "Scenario", "at_intersection", "on_network"]

WEATHER = {"dry": 0.85, "wet": 0.5}
"""Weather -> friction coefficient of the road, from another source (Zhao et al. 2025, 3.1 and 3.2)."""


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
        demand: the traffic at `intersection`, which is then what `routes` would be; None for scenarios without.
        intersection: where `demand` goes.
        scale: factor on all flows by the scenario's own options.
        factor: and by whoever runs it.
        variation: what `varied` made of it, for the name of a run; empty for nothing.
        weather: that `mu` stands for, one of `WEATHER`; empty where nothing is said of it.
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
    demand: Demand | None = None
    intersection: Intersection | None = None
    scale: float = 1.0
    factor: float = 1.0
    variation: str = ""
    weather: str = ""
    seed: int | None = 1
    step_length: float | None = 0.1
    duration: float | None = 600.0
    output_prefix: str = ""

    def __post_init__(self) -> None:
        """Raises `InputError` for a friction that no road has."""
        if not MU_RANGE[0] <= self.mu <= MU_RANGE[1]:
            raise InputError("friction of {} must be within {} .. {}, not {:g}".format(self.name, *MU_RANGE, self.mu))

    @property
    def vehicles(self) -> str:
        """Content of the SUMO route file that the scenario brings as text; empty for none."""
        if self.demand is None or self.intersection is None:
            return self.routes
        return routes(self.intersection, replace(self.demand, flow=self.demand.flow * self.factor))

    @property
    def sumo_options(self) -> tuple[str, ...]:
        """`options`, and what the other fields make of SUMO's."""
        own = self.demand is not None or self.factor == 1
        return self.options if own else (*self.options, "--scale", f"{self.scale * self.factor:.9g}")

    def varied(
        self,
        *,
        demand: float | None = None,
        ebike_share: float | None = None,
        weather: str | None = None,
        mu: float | None = None,
        drivers: Profile | None = None,
    ) -> "Scenario":
        """The scenario with another demand, share of e-bikes, weather, friction or drivers; None leaves what there is.

        Args:
            demand: factor on all flows.
            ebike_share: of the road users.
            weather: one of `WEATHER`.
            mu: friction coefficient of the road; wins over that of the weather.
            drivers: what they do wrong.

        Raises:
            InputError: one is out of range, or the scenario has no flows or no share of e-bikes to change.
        """
        new = self
        if demand is not None:
            if not 0 < demand < np.inf:
                raise InputError(f"demand must be a positive factor, not {demand:g}")
            if new.drivers.robots is not None:
                raise InputError(f"{self.name} has no flows for a demand to multiply")
            new = replace(new, factor=new.factor * demand)
        if ebike_share is not None:
            if new.demand is None:
                known = registered(__package__, "SCENARIO").values()
                there = ", ".join(s.name for s in known if s.demand is not None)
                raise InputError(f"{self.name} has no share of e-bikes to set; these have: {there}")
            new = replace(new, demand=replace(new.demand, ebike_share=ebike_share))
        if weather is not None:
            if weather not in WEATHER:
                raise InputError(f"weather must be one of {', '.join(WEATHER)}, not {weather!r}")
            new = replace(new, weather=weather, mu=WEATHER[weather])
        if mu is not None:
            new = replace(new, mu=mu)
        if drivers is not None:
            new = replace(new, drivers=drivers)
        tags = [
            self.variation,
            "" if demand is None else f"demand{demand:g}",
            "" if ebike_share is None else f"ebikes{ebike_share:g}",
            weather or "",
            "" if mu is None else f"mu{mu:g}",
            "" if drivers is None else Path(drivers.name).stem,
        ]
        return replace(new, variation="-".join(tag for tag in tags if tag))


def on_network(name: str) -> tuple[str, ...]:
    """SUMO options for one of the networks of `sumo_nets` and the traffic that lies beside it."""
    folder = sumo_nets.folder(name)
    return ("--net-file", str(folder / f"{name}.net.xml"), "--route-files", str(folder / f"{name}.rou.xml"))


def at_intersection(name: str, intersection: Intersection, demand: Demand, drivers: Profile) -> Scenario:
    """A scenario at one of the intersections of `sumo_nets`.

    Args:
        name: of the scenario and of the network.
        intersection: what the net was built from.
        demand: its traffic.
        drivers: what they do wrong.
    """
    files = sumo_nets.folder(name) / name
    return Scenario(
        name=name,
        options=("--net-file", f"{files}.net.xml", "--additional-files", f"{files}.add.xml", *OPTIONS),
        drivers=drivers,
        demand=demand,
        intersection=intersection,
        duration=1800.0,
    )
