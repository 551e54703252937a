"""Accident type 322: a car goes straight on, an e-bike crosses from the left and has priority."""

from aeb_sumo.drivers.errors import Errors, FailureToYield
from aeb_sumo.scenarios.typologies import conflict

__all__ = ["SCENARIO"]

SCENARIO = conflict(
    "322",
    "crossroads",
    Errors(failure_to_yield=FailureToYield()),
    cars=("wi", "eo"),
    riders=("ni", "so"),
    cars_per_hour=300.0,
    riders_per_hour=700.0,
)
