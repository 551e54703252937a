"""How many runs per hour a campaign does with one and with two workers: `python tests/benchmarks/campaign.py [RUNS]`.

One worker and two take turns, three times; what counts is the best of each, as other programs can only slow a run down.
"""

import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from aeb_sumo.campaign.expansion import expand
from aeb_sumo.campaign.runner import execute_all
from aeb_sumo.campaign.spec import read

SPEC = """[factors]
scenario = "highway"
strategy = "staged"
seed = "1..{runs}"
[run]
duration_s = 120
"""
ROUNDS = 3
WANTED = 1.8


def per_hour(runs: int, workers: int) -> float:
    """Runs per hour of a campaign in a new folder."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "spec.toml"
        path.write_text(SPEC.format(runs=runs), encoding="utf-8")
        jobs = expand(read(path))
        began = time.monotonic()
        with ThreadPoolExecutor(workers) as executor:
            outcomes = execute_all(jobs, str(Path(folder) / "out"), executor)
        elapsed = time.monotonic() - began
    assert [each.outcome for each in outcomes] == ["completed"] * runs, outcomes
    return 3600 * runs / elapsed


def main() -> None:
    """Measure and print."""
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 60
    best = {1: 0.0, 2: 0.0}
    for number in range(ROUNDS):
        for workers in (1, 2):
            found = per_hour(runs, workers)
            best[workers] = max(best[workers], found)
            print(f"round {number + 1}, workers {workers}: {found:.0f} runs per hour", flush=True)
    ratio = best[2] / best[1]
    print(f"{runs} runs of 120 s on the highway: {best[1]:.0f} and {best[2]:.0f} per hour, ratio {ratio:.2f}")
    sys.exit(ratio < WANTED)


if __name__ == "__main__":
    main()
