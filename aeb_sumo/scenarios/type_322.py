"""Accident type 322: a car goes straight on, an e-bike crosses from the left and has priority."""

from aeb_sumo.drivers import profile
from aeb_sumo.scenarios.typologies import conflict

__all__ = ["SCENARIO"]

SCENARIO = conflict(
    "322",
    "crossroads",
    profile.load("intersection"),
    cars=("wi", "eo"),
    riders=("ni", "so"),
    cars_per_hour=450.0,
    riders_per_hour=900.0,
)
