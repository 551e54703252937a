"""What a crash did to the people in it."""

from collections.abc import Sequence

from aeb_sumo.severity import death_risk, serious_risk
from aeb_sumo.world.contact import Impact
from aeb_sumo.world.kinds import VClasses

__all__ = ["risks"]

# An e-bike rider is a cyclist, as in the source, or drives a moped, as SUMO's class may say.
_EBIKES = frozenset({"bicycle", "scooter", "moped"})
_ROAD_USERS = {
    "bicycle": "cyclist", "scooter": "cyclist", "moped": "motorcyclist", "motorcycle": "motorcyclist",
    "pedestrian": "pedestrian", **dict.fromkeys(VClasses.CARS, "car_driver"),
}  # fmt: skip


def risks(hit: Impact, kind: str, vclass: Sequence[str]) -> dict[str, float | None]:
    """Columns `*_risk` of table `crashes`; None where no curve applies.

    The curves are for who is hit by the front of a passenger car: the struck, and in a head-on crash the striker too.

    Args:
        hit: the impact.
        kind: of the crash.
        vclass: per slot, SUMO's vehicle class.
    """
    columns: dict[str, float | None] = {}
    for who, slot, other, speed, applies in (
        ("striker", hit.striker, hit.struck, hit.struck_speed, kind == "head_on"),
        ("struck", hit.struck, hit.striker, hit.striker_speed, True),
    ):
        person, by_car = vclass[slot], applies and vclass[other] in VClasses.CARS
        user = _ROAD_USERS.get(person)
        columns[f"{who}_death_risk"] = float(death_risk(speed)) if by_car and person in _EBIKES else None
        columns[f"{who}_serious_risk"] = float(serious_risk(user, hit.impact_speed)) if by_car and user else None
    return columns
