"""Accident type 601: a car runs into an e-bike ahead of it, on lanes for everybody."""

from aeb_sumo.drivers import profile
from aeb_sumo.scenarios.typologies import conflict

__all__ = ["SCENARIO"]

_CAR = '<vType id="car" vClass="passenger" length="4.6" width="1.82" speedFactor="normc(0.9,0.1,0.6,1.2)"/>'

SCENARIO = conflict(
    "601",
    "street",
    profile.load("inattentive"),
    cars=("street",),
    riders=("street",),
    cars_per_hour=700.0,
    riders_per_hour=150.0,
    car=_CAR,
)
