"""Small runs with literal results. A change here means that every user's numbers change: say why in the commit."""

import pytest

RUNS = [
    # The robot drives into the standing car at 40 km/h 4.5 s after both have departed at 0.1 s; with AEB it does not.
    ("track", "none", 20),
    ("track", "zhao2025", 20),
    # Two drivers do not brake in time; their AEBs are among the fourteen that brake.
    ("highway", "none", 240),
    ("highway", "zhao2025", 240),
    # Left turns across e-bikes; wrecks in the junction cost the baseline 38 arrivals.
    ("w0", "none", 600),
    ("w0", "zhao2025", 600),
]


@pytest.mark.parametrize(("scenario", "strategy", "duration"), RUNS)
def test_run(aeb_golden, scenario, strategy, duration):
    aeb_golden(scenario, strategy, duration=duration)
