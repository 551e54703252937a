"""Accident type 321: a car goes straight on, an e-bike crosses from the right and has priority."""

from aeb_sumo.drivers import profile
from aeb_sumo.scenarios.typologies import conflict

__all__ = ["SCENARIO"]

SCENARIO = conflict(
    "321",
    "crossroads",
    profile.load("intersection"),
    cars=("wi", "eo"),
    riders=("si", "no"),
    cars_per_hour=450.0,
    riders_per_hour=900.0,
)
