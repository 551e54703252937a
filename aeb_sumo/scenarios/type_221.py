"""Accident type 221: a car turns left across an oncoming e-bike."""

from aeb_sumo.drivers.errors import Errors, FailureToYield
from aeb_sumo.scenarios.typologies import conflict

__all__ = ["SCENARIO"]

SCENARIO = conflict(
    "221",
    "w0",
    Errors(failure_to_yield=FailureToYield()),
    cars=("si", "wo"),
    riders=("ni", "so"),
    cars_per_hour=500.0,
    riders_per_hour=700.0,
)
