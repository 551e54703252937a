"""Proving ground: CCRs at 40 km/h from 50 m (Zhao et al. 2025, Table 6), driven by robots that never react."""

from aeb_sumo.drivers.profile import ROBOTS
from aeb_sumo.scenarios.base import Scenario, on_network

__all__ = ["SCENARIO"]

SCENARIO = Scenario(name="track", options=on_network("track"), drivers=ROBOTS, duration=20.0)
