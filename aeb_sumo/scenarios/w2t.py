"""W2T (Yan et al. 2025, Table 1): three arms, three car lanes each way; left-turning drivers overlook e-bikes."""

from aeb_sumo.drivers import profile
from aeb_sumo.scenarios.base import at_intersection
from aeb_sumo.scenarios.demand import Demand
from sumo_nets.w2t.sources import INTERSECTION

__all__ = ["SCENARIO"]

SCENARIO = at_intersection("w2t", INTERSECTION, Demand(flow=1120.0), profile.load("intersection"))
