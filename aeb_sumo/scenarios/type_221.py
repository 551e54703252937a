"""Accident type 221: a car turns left across an oncoming e-bike."""

from aeb_sumo.drivers import profile
from aeb_sumo.scenarios.typologies import conflict

__all__ = ["SCENARIO"]

SCENARIO = conflict(
    "221",
    "w0",
    profile.load("intersection"),
    cars=("si", "wo"),
    riders=("ni", "so"),
    cars_per_hour=500.0,
    riders_per_hour=700.0,
)
