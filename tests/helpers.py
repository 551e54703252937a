"""Makes inputs for tests."""

import numpy as np

from aeb_sumo.strategies.base import Percept


def approach(ego_kmh: float, lead_kmh: float, gap: float) -> str:
    """An ego behind a lead, bumper to bumper `gap` apart."""
    return (
        f'<vehicle id="lead" type="car" route="r" depart="0" departLane="0" insertionChecks="none" departPos="{604.6 + gap}" departSpeed="{lead_kmh / 3.6}"/>'
        f'<vehicle id="ego" type="car" route="r" depart="0" departLane="0" insertionChecks="none" departPos="600" departSpeed="{ego_kmh / 3.6}"/>'
    )


def percept(**values: object) -> Percept:
    """A percept of one row per value; a valid one on a dry road unless told otherwise."""
    defaults = {"gap": 50.0, "ego_speed": 20.0, "ego_accel": 0.0, "target_speed": 0.0, "target_accel": 0.0, "mu": 0.85}
    n = max(np.size(v) for v in values.values()) if values else 1
    given = {k: np.broadcast_to(np.asarray(values.get(k, d), float), n).copy() for k, d in defaults.items()}
    return Percept(valid=np.broadcast_to(np.asarray(values.get("valid", True)), n).copy(), **given)
