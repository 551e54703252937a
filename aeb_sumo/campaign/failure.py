"""The row in `runs` of a run that died: what it was of, how it ended, and nothing of what it would have shown."""

from math import isnan
from typing import Any

import aeb_sumo
from aeb_sumo.campaign.settings import Settings

__all__ = ["row_of"]


def row_of(run_id: str, settings: Settings, reason: str) -> dict[str, Any]:
    """A row of `runs`; columns that only a simulation can fill are missing.

    Args:
        run_id: the run.
        settings: what it was of.
        reason: how it ended.
    """
    scenario, carried = settings.world.make(), settings.carried.make()
    return {
        "run_id": run_id,
        "scenario": scenario.name,
        "strategy": carried.name,
        "sensing": carried.sensing,
        "parameters": carried.parameters,
        "penetration": None if isnan(carried.penetration) else carried.penetration,
        "seed": settings.seed,
        "drivers": scenario.drivers.name,
        "step_length_s": settings.step_length_s or scenario.step_length,
        "demand": scenario.scale * scenario.factor,
        "ebike_share": scenario.demand.ebike_share if scenario.demand else None,
        "weather": scenario.weather,
        "mu": scenario.mu,
        "blockage_s": settings.blockage_s,
        "outcome": "failed",
        "reason": reason,
        "aeb_sumo_version": aeb_sumo.__version__,
    }
