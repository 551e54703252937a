"""Test cases of the proving ground: two road users, driven by robots, as text for SUMO.

`approach` is every car-to-car rear case (CCRs, CCRm, CCRb), `left_turn` the turn across an oncoming e-bike (CBTA). The
one under test is called `ego`, the other `target`. SUMO inserts both at the end of its first step: that is when the
clock of a case starts.
"""

from dataclasses import replace

import sumo_nets
from aeb_sumo.drivers.lapses import Lapse, Robots
from aeb_sumo.drivers.profile import ROBOTS
from aeb_sumo.errors import InputError
from aeb_sumo.scenarios.base import Scenario
from aeb_sumo.units import KMH
from aeb_sumo.world.friction import Stretch
from sumo_nets.left_turn.sources import APPROACH, crossing

__all__ = ["EGO", "START", "TARGET", "approach", "left_turn"]

EGO, TARGET = "ego", "target"

START = 600.0
"""Where the ego's front bumper is on the track at the start of an approach [m]."""

_LENGTH, _WIDTH = 4.6, 1.82  # m, of both cars; from another source (seeds.md 4.4), for Yan's car
_EBIKE_LENGTH = 1.8  # m, the same
_MEET = 6.0  # s after the start of a left turn, our assumption: long enough for any warning

_CAR = (
    f'vClass="passenger" length="{_LENGTH}" width="{_WIDTH}" sigma="0" speedDev="0" maxSpeed="60" '
    'lcSpeedGain="0" lcKeepRight="0" lcStrategic="-1" latAlignment="arbitrary"'
)


def approach(
    name: str,
    *,
    ego: float,
    lead: float,
    gap: float,
    mu: float = 0.85,
    stretches: tuple[Stretch, ...] = (),
    overlap: float = 1.0,
    braking: tuple[float, float] | None = None,
    ego_braking: tuple[float, float] | None = None,
    step_length: float = 0.02,
    duration: float = 20.0,
) -> Scenario:
    """One car behind another on the straight track.

    Args:
        name: of the case.
        ego: speed [m/s].
        lead: speed [m/s].
        gap: bumper to bumper at the start [m].
        mu: friction coefficient of the road.
        stretches: where it is another; the ego starts at `START` on edge `track`.
        overlap: share of the lead's width that lies in the ego's, above 0 to 1; below 1 SUMO's sublane model is on.
        braking: instant [s] from which the lead brakes to a stop, and how hard [m/s2]; None: it does not.
        ego_braking: the same for the ego, before its AEB does.
        step_length: [s].
        duration: [s].

    Raises:
        InputError: a speed, the gap, the overlap or the friction is out of range.
    """
    for quantity, value, low, high in (
        ("ego speed", ego, 0.0, 100.0),
        ("lead speed", lead, 0.0, 100.0),
        ("gap", gap, 0.1, 2000.0),
        ("overlap", overlap, 0.05, 1.0),
    ):
        if not low <= value <= high:
            raise InputError(f"{quantity} of {name} must be within {low:g} .. {high:g}, not {value:g}")
    programs = [
        (vehicle, (Lapse(plan[0], 1e9, -plan[1]),))
        for vehicle, plan in ((EGO, ego_braking), (TARGET, braking))
        if plan is not None
    ]
    sublane = ("--lateral-resolution", "0.4") if overlap < 1 else ()
    net = sumo_nets.folder("track") / "track.net.xml"
    aside = (1 - overlap) * _WIDTH
    return Scenario(
        name=name,
        options=("--net-file", str(net), *sublane),
        routes=f"""<routes>
    <vType id="car" {_CAR}/>
    <route id="ahead" edges="track"/>
    {_vehicle(TARGET, "car", "ahead", START + gap + _LENGTH, lead, aside)}
    {_vehicle(EGO, "car", "ahead", START, ego, 0.0)}
</routes>
""",
        drivers=replace(ROBOTS, robots=Robots(programs=tuple(programs))),
        mu=mu,
        stretches=stretches,
        step_length=step_length,
        duration=duration,
    )


def left_turn(
    name: str, *, ego_kmh: int, ebike: float = 20 * KMH, mu: float = 0.85, step_length: float = 0.01
) -> Scenario:
    """A car turns left across an oncoming e-bike on the path of Yan et al. 2025, Table 3, a = 4.8 m (type W0).

    Without braking the middle of the car's front bumper meets the middle of the e-bike.

    Args:
        name: of the case.
        ego_kmh: speed [km/h]: 10, 20 or 30.
        ebike: its speed [m/s]; 20 km/h is printed.
        mu: friction coefficient of the road.
        step_length: [s].
    """
    net = sumo_nets.folder("left_turn") / "left_turn.net.xml"
    car_at = APPROACH + crossing(ego_kmh)[0] - ego_kmh * KMH * _MEET
    ebike_at = APPROACH + _EBIKE_LENGTH / 2 - ebike * _MEET
    return Scenario(
        name=name,
        options=("--net-file", str(net)),
        routes=f"""<routes>
    <vType id="car" {_CAR}/>
    <vType id="ebike" vClass="bicycle" length="{_EBIKE_LENGTH}" width="0.7" sigma="0" speedDev="0" maxSpeed="15"/>
    <route id="turn" edges="car_{ego_kmh} exit_{ego_kmh}"/>
    <route id="straight" edges="ebike_{ego_kmh} beyond_{ego_kmh}"/>
    {_vehicle(TARGET, "ebike", "straight", ebike_at, ebike, 0.0)}
    {_vehicle(EGO, "car", "turn", car_at, ego_kmh * KMH, 0.0)}
</routes>
""",
        drivers=ROBOTS,
        mu=mu,
        step_length=step_length,
        duration=_MEET + 3.0,
    )


def _vehicle(name: str, kind: str, route: str, position: float, speed: float, aside: float) -> str:
    beside = f' departPosLat="{aside:.4f}"' if aside else ""
    return (
        f'<vehicle id="{name}" type="{kind}" route="{route}" depart="0" departLane="0" departPos="{position:.6f}" '
        f'departSpeed="{speed:.9f}"{beside} insertionChecks="none"/>'
    )
