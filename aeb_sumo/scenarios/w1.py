"""W1 (Yan et al. 2025, Table 1): no median, two car lanes each way; left-turning drivers overlook e-bikes."""

from aeb_sumo.drivers import profile
from aeb_sumo.scenarios.base import at_intersection
from aeb_sumo.scenarios.demand import Demand
from sumo_nets.w1.sources import INTERSECTION

__all__ = ["SCENARIO"]

SCENARIO = at_intersection("w1", INTERSECTION, Demand(), profile.load("intersection"))
