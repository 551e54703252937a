"""Small runs with literal results. A change here means that every user's numbers change: say why in the commit."""

import pytest

RUNS = [
    # The robot drives into the standing car at 40 km/h 4.5 s after both have departed at 0.1 s; with AEB it does not.
    ("track", "none", 20),
    ("track", "zhao2025", 20),
    # Free traffic that fills up: leads brake hard, nobody crashes yet.
    ("highway", "none", 150),
    ("highway", "zhao2025", 150),
    # Left turns across e-bikes, riders at red: crashes without AEB, none with it.
    ("w0", "none", 300),
    ("w0", "zhao2025", 300),
]


@pytest.mark.parametrize(("scenario", "strategy", "duration"), RUNS)
def test_run(aeb_golden, scenario, strategy, duration):
    aeb_golden(scenario, strategy, duration=duration)
