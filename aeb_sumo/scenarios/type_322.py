"""Accident type 322: a car goes straight on, an e-bike crosses from the left and has priority."""

from aeb_sumo.drivers.errors import Errors, FailureToYield
from aeb_sumo.scenarios.typologies import conflict

__all__ = ["SCENARIO"]

SCENARIO = conflict(
    "322",
    "crossroads",
    Errors(failure_to_yield=FailureToYield(probability=0.7, rider_unaware=0.7)),
    cars=("wi", "eo"),
    riders=("ni", "so"),
    cars_per_hour=450.0,
    riders_per_hour=900.0,
)
