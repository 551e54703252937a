"""Traffic at an intersection from parameters, as text for SUMO: cars and e-bikes, Poisson flows per movement."""

from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from aeb_sumo.errors import InputError
from aeb_sumo.parameters import check, within
from aeb_sumo.units import KMH
from sumo_nets.intersection import ARMS, LEFT, OPPOSITE, RIGHT, Intersection

__all__ = ["CAR", "LATERAL_RESOLUTION", "OPTIONS", "TELEPORT_AFTER", "Demand", "Rider", "routes"]

LATERAL_RESOLUTION = 0.35
"""Width of SUMO's sublanes [m], our assumption: half of an e-bike."""

TELEPORT_AFTER = 90
"""When SUMO takes away who cannot go on [s]. A wreck in the middle of a junction can lock up everyone around it; SUMO's
own value is 300. Our assumption: the 60 s that wrecks stand, and a phase of the signal."""

OPTIONS = ("--lateral-resolution", f"{LATERAL_RESOLUTION:g}", "--time-to-teleport", f"{TELEPORT_AFTER:g}")
"""What SUMO needs for this traffic."""

CAR = (
    '<vType id="car" vClass="passenger" length="4.6" width="1.82" speedFactor="normc(0.9,0.1,0.6,1.2)" '
    'latAlignment="center" lcSublane="0" lcSpeedGain="0" lcKeepRight="0"/>'
)
"""Yan's car (seeds.md 4.4), which stays in the middle of its lane; its speed factor is our assumption."""

_ALIGNMENTS = ("left", "right", "center", "compact", "nice", "arbitrary")
_TYPES = 20  # e-bike types with a speed each; SUMO itself knows normal distributions of speed only


@dataclass(frozen=True, kw_only=True)
class Rider:
    """E-bikes and how they are ridden.

    Attributes:
        speed: mean on segments [m/s]; 17.1 km/h from another source (Hangzhou, V in evidence.md).
        speed_sd: standard deviation of the log-normal speed [m/s]; 3.5 km/h, our assumption.
        max_speed: legal limit [m/s]; 25 km/h, from another source (evidence.md, V).
        length: [m]; 1.8 from another source (seeds.md 4.4).
        width: [m]; 0.7 from the same.
        min_gap: to who is ahead, at standstill [m], our assumption.
        accel: [m/s2], our assumption.
        decel: [m/s2], our assumption.
        emergency_decel: [m/s2], our assumption.
        lateral_gap: to who is beside [m], our assumption.
        lateral_speed: of moving aside [m/s], our assumption.
        alignment: where in the lane, in SUMO's words; "arbitrary", our assumption: where they happen to ride, which is
            on average the middle.
        overtaking: eagerness to pass others in the lane (SUMO's lcSpeedGain and lcSublane); 0, our assumption: SUMO's
            riders touch those whom they pass.
    """

    speed: float = within(17.1 * KMH, 0.5, 20.0)
    speed_sd: float = within(3.5 * KMH, 0.0, 5.0)
    max_speed: float = within(25.0 * KMH, 0.5, 30.0)
    length: float = within(1.8, 0.5, 4.0)
    width: float = within(0.7, 0.2, 2.0)
    min_gap: float = within(1.0, 0.0, 5.0)
    accel: float = within(1.2, 0.1, 5.0)
    decel: float = within(3.0, 0.5, 9.0)
    emergency_decel: float = within(6.0, 0.5, 12.0)
    lateral_gap: float = within(0.3, 0.0, 2.0)
    lateral_speed: float = within(0.5, 0.1, 3.0)
    alignment: str = "arbitrary"
    overtaking: float = within(0.0, 0.0, 100.0)

    def __post_init__(self) -> None:
        """Raises `InputError` for a number that is out of range, or an alignment that SUMO does not know."""
        check(self)
        if self.alignment not in _ALIGNMENTS:
            allowed = ", ".join(_ALIGNMENTS)
            raise InputError(f"Rider.alignment must be one of {allowed}, not {self.alignment!r}")

    def speeds(self) -> list[float]:
        """Speeds of equally frequent types [m/s]: the middles of as many slices of the distribution, capped."""
        spread = np.log1p((self.speed_sd / self.speed) ** 2)
        probit = np.array([NormalDist().inv_cdf((k + 0.5) / _TYPES) for k in range(_TYPES)])
        speeds = self.speed * np.exp(np.sqrt(spread) * probit - spread / 2)
        return np.minimum(speeds, self.max_speed).tolist()  # type: ignore[no-any-return]

    def types(self) -> str:
        """SUMO's distribution of vehicle types `ebike`."""
        same = (
            f'vClass="bicycle" length="{self.length:g}" width="{self.width:g}" minGap="{self.min_gap:g}" '
            f'accel="{self.accel:g}" decel="{self.decel:g}" emergencyDecel="{self.emergency_decel:g}" '
            f'speedFactor="1" speedDev="0" desiredMaxSpeed="{max(13.89, self.max_speed):g}" '
            f'latAlignment="{self.alignment}" minGapLat="{self.lateral_gap:g}" maxSpeedLat="{self.lateral_speed:g}" '
            f'lcSpeedGain="{self.overtaking:g}" lcSublane="{self.overtaking:g}"'
        )
        rows = [f'<vType id="ebike_{k:02}" maxSpeed="{v:.3f}" {same}/>' for k, v in enumerate(self.speeds())]
        return "\n    ".join(
            ['<vTypeDistribution id="ebike">', *("    " + row for row in rows), "</vTypeDistribution>"]
        )


@dataclass(frozen=True, kw_only=True)
class Demand:
    """Who comes to an intersection. All shares are our assumptions; movements that an arm has not are left out.

    Attributes:
        flow: road users per hour, all arms together, our assumption.
        ebike_share: of them on e-bikes.
        main_share: of both kinds on the road that goes through (of two, that from north to south), where there are
            four arms; of three, the one that ends has half of the rest.
        left: share of cars that turn left; far above life, so that a short run has conflicts.
        right: share of cars that turn right.
        rider_left: share of riders who turn left.
        rider_right: share of riders who turn right.
        against: share of riders who come against the lane; they go straight on.
        rider: e-bikes and how they are ridden.
    """

    flow: float = within(1400.0, 0.0, 20000.0)
    ebike_share: float = within(0.7, 0.0, 1.0)
    main_share: float = within(0.6, 0.0, 1.0)
    left: float = within(0.4, 0.0, 1.0)
    right: float = within(0.1, 0.0, 1.0)
    rider_left: float = within(0.1, 0.0, 1.0)
    rider_right: float = within(0.1, 0.0, 1.0)
    against: float = within(0.05, 0.0, 1.0)
    rider: Rider = Rider()

    def __post_init__(self) -> None:
        """Raises `InputError` for a number out of range, or shares that sum up to more than 1."""
        check(self)
        for names in (("left", "right"), ("rider_left", "rider_right", "against")):
            total = sum(getattr(self, name) for name in names)
            if total > 1 + 1e-9:
                raise InputError(f"Demand: {' + '.join(names)} must be 1 or less, not {total:g}")

    def flows(self, intersection: Intersection) -> dict[str, tuple[str, tuple[str, ...], float]]:
        """Flow -> type, the edges of its route, vehicles per second."""
        result: dict[str, tuple[str, tuple[str, ...], float]] = {}
        weights = {a: self.main_share if a in intersection.main else 1 - self.main_share for a in intersection.arms}
        for arm in (a for a in ARMS if a in intersection.arms):
            rate = self.flow / 3600 * weights[arm] / max(sum(weights.values()), 1e-9)
            for kind, share, split in (
                ("car", 1 - self.ebike_share, self._cars(intersection, arm)),
                ("ebike", self.ebike_share, self._riders(intersection, arm)),
            ):
                total = sum(split.values())
                for way, weight in split.items():
                    against = "c" if way == "against" else ""
                    to = {"left": LEFT, "right": RIGHT}.get(way, OPPOSITE)[arm]
                    name = f"{kind}_{arm}{to}" + ("_against" if against else "")
                    staged = kind == "ebike" and way == "left" and intersection.waiting_area(arm)
                    waits = (f"{arm}lo", f"{arm}li") if staged else ()
                    if rate * share * weight > 0:
                        edges = (f"{arm}{against}i", *waits, f"{to}{against}o")
                        result[name] = kind, edges, rate * share * weight / total
        return result

    def _cars(self, intersection: Intersection, arm: str) -> dict[str, float]:
        split = {"left": self.left, "straight": 1 - self.left - self.right, "right": self.right}
        return {way: share for way, share in split.items() if way in intersection.movements(arm)}

    def _riders(self, intersection: Intersection, arm: str) -> dict[str, float]:
        split = {"left": self.rider_left, "right": self.rider_right, "against": self.against}
        split["straight"] = 1 - sum(split.values())
        there = set(intersection.movements(arm))
        if intersection.bike_left == "none":
            there -= {"left"}
        if intersection.contraflow and "straight" in there:
            there |= {"against"}
        return {way: share for way, share in split.items() if way in there}


def routes(intersection: Intersection, demand: Demand) -> str:
    """The traffic as a SUMO route file; random intervals (Poisson), so that memory does not grow with the duration."""
    flows = demand.flows(intersection)
    aside = {"car": "", "ebike": ' departPosLat="random"'}
    lines = [CAR, demand.rider.types()]
    lines += [f'<route id="{name}" edges="{" ".join(edges)}"/>' for name, (_, edges, _) in flows.items()]
    lines += [
        f'<flow id="{name}" type="{kind}" route="{name}" begin="0" end="86400" period="exp({rate:.9g})" '
        f'departLane="best" departSpeed="desired"{aside[kind]}/>'
        for name, (kind, _, rate) in flows.items()
    ]
    return "\n".join(["<routes>", *("    " + line for line in lines), "</routes>", ""])
