"""Which vehicle types a scenario has: SUMO is asked before any run."""

import tempfile
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

from aeb_sumo.scenarios import Scenario
from aeb_sumo.scenarios.options import start_options
from aeb_sumo.world.session import Session

__all__ = ["vehicle_types"]


def vehicle_types(scenario: Scenario) -> frozenset[str]:
    """Ids of the types that a run knows at its begin.

    Raises:
        InputError: SUMO refuses the scenario.
    """
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:  # SUMO leaves traces in its process
        return pool.submit(_ask, scenario).result()


def _ask(scenario: Scenario) -> frozenset[str]:
    with tempfile.TemporaryDirectory() as nowhere, Session(start_options(scenario, Path(nowhere))) as session:
        return session.vehicle_types
