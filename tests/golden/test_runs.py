"""Small runs with literal results. A change here means that every user's numbers change: say why in the commit."""

import pytest

from aeb_sumo import scenarios
from aeb_sumo.simulate import run

# scenario, duration s, strategy: vehicles, crashes, interventions, arrivals, km, first crash (instant s, impact m/s).
GOLDEN = {
    # The robot drives into the standing car at 40 km/h 4.5 s after both have departed at 0.1 s; with AEB it does not.
    ("track", 20, "none"): (2, {"rear_end": 1}, {}, 0, 0.05, (4.6, 11.111)),
    ("track", 20, "zhao2025"): (2, {}, {"partial_brake": 1}, 0, 0.049, None),
    # Two drivers do not brake in time; their AEBs are among the fourteen that brake.
    ("highway", 240, "none"): (272, {"rear_end": 2}, {}, 59, 678.98, (215.792, 1.614)),
    ("highway", 240, "zhao2025"): (272, {}, {"partial_brake": 14, "warn": 159}, 61, 698.844, None),
    # Left turns across e-bikes; wrecks in the junction cost the baseline 38 arrivals.
    ("w0", 600, "none"): (301, {"left_turn_across_path": 4}, {}, 198, 121.035, (87.895, 9.248)),
    ("w0", 600, "zhao2025"): (301, {}, {"full_brake": 4, "partial_brake": 4, "warn": 147}, 236, 134.129, None),
}


@pytest.mark.parametrize("key", GOLDEN, ids=[" ".join(map(str, k)) for k in GOLDEN])
def test_run(key):
    name, duration, strategy = key
    result = run(scenarios.load(name), strategy, duration=duration)
    crashes = result.crashes
    first = None
    if len(crashes):
        first = round(crashes["time_s"].iloc[0], 3), round(crashes["impact_speed_mps"].iloc[0], 3)
    assert (
        result.runs["vehicles"].item(),
        crashes["kind"].value_counts().to_dict(),
        result.interventions["phase"].value_counts().to_dict(),
        result.traffic["arrived"].sum(),
        round(result.exposure["distance_m"].sum() / 1000, 3),
        first,
    ) == GOLDEN[key]
