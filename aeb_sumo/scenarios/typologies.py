"""What the scenarios of single accident types have in common."""

import sumo_nets
from aeb_sumo.drivers.profile import Profile
from aeb_sumo.scenarios.base import Scenario
from aeb_sumo.scenarios.demand import CAR, OPTIONS, Rider

__all__ = ["conflict"]


def conflict(
    name: str,
    net: str,
    drivers: Profile,
    *,
    cars: tuple[str, ...],
    riders: tuple[str, ...],
    cars_per_hour: float,
    riders_per_hour: float,
    car: str = CAR,
) -> Scenario:
    """Cars on one route and e-bikes on another, Poisson; 600 s, far more conflicts than in life.

    Args:
        name: of the scenario.
        net: network of `sumo_nets`.
        drivers: what the drivers do wrong.
        cars: edges of their route.
        riders: edges of theirs.
        cars_per_hour: their flow, our assumption.
        riders_per_hour: theirs, our assumption.
        car: vehicle type of the cars.
    """
    flows = "\n".join(
        f'    <route id="{kind}" edges="{" ".join(edges)}"/>\n'
        f'    <flow id="{kind}" type="{kind}" route="{kind}" begin="0" end="86400" period="exp({flow / 3600:.9g})" '
        f'departLane="{lane}" departSpeed="desired"/>'
        for kind, edges, flow, lane in (
            ("car", cars, cars_per_hour, "best"),
            ("ebike", riders, riders_per_hour, "first"),
        )
    )
    return Scenario(
        name=name,
        options=("--net-file", str(sumo_nets.folder(net) / f"{net}.net.xml"), *OPTIONS),
        routes=f"<routes>\n    {car}\n    {Rider().types()}\n{flows}\n</routes>\n",
        drivers=drivers,
        duration=600.0,
    )
