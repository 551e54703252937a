"""Highway: three lanes, an on-ramp, a lane drop with a queue; drivers look away, and leads brake hard."""

from aeb_sumo.drivers import profile
from aeb_sumo.scenarios.base import Scenario, on_network

__all__ = ["SCENARIO"]

SCENARIO = Scenario(
    name="highway",
    options=on_network("highway"),
    drivers=profile.load("highway"),
)
