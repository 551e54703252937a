"""W0: a signalised two-way intersection with e-bike lanes; some left-turning drivers overlook an oncoming e-bike."""

from aeb_sumo.drivers.errors import Errors, FailureToYield
from aeb_sumo.scenarios.base import Scenario, on_network

__all__ = ["SCENARIO"]

SCENARIO = Scenario(name="w0", options=on_network("w0"), errors=Errors(failure_to_yield=FailureToYield()))
