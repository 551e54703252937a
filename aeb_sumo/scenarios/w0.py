"""W0: a signalised two-way intersection with e-bike lanes; some left-turning drivers overlook an oncoming e-bike."""

from aeb_sumo.drivers import profile
from aeb_sumo.scenarios.base import Scenario, on_network

__all__ = ["SCENARIO"]

SCENARIO = Scenario(
    name="w0",
    # A wreck in the middle of the junction can lock up everyone around it; SUMO's way out is to teleport, after 300 s
    # by default. 90 s is our assumption: the 60 s that wrecks stand, and a phase of the signal.
    options=(*on_network("w0"), "--time-to-teleport", "90"),
    drivers=profile.load("intersection"),
    duration=1800.0,
)
