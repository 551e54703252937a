"""W0 (Yan et al. 2025, Table 1): no median, one car lane each way; left-turning drivers overlook e-bikes."""

from aeb_sumo.drivers import profile
from aeb_sumo.scenarios.base import at_intersection
from aeb_sumo.scenarios.demand import Demand
from sumo_nets.w0.sources import INTERSECTION

__all__ = ["SCENARIO"]

SCENARIO = at_intersection("w0", INTERSECTION, Demand(), profile.load("intersection"))
