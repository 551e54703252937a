"""A long run needs no more memory than a short one, when its rows go to a folder."""

import subprocess
import sys

import pytest

# The first half of a run is what a run of half the duration would have been.
_RUN = """
import resource, sys
from aeb_sumo.scenarios import load
from aeb_sumo.simulate import run

def peak():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

def progress(now):
    if abs(now.time - now.duration / 2) < 0.01:
        print(peak())

result = run(load(sys.argv[1]), sys.argv[2], duration=float(sys.argv[3]), progress=progress, out=sys.argv[4])
print(peak())
print(result.runs["vehicles"].item())
"""


@pytest.mark.slow
def test_doubling_the_duration_raises_peak_memory_by_less_than_a_twentieth(tmp_path):
    """From 4 minutes on as many leave the intersection as come to it."""
    call = [sys.executable, "-c", _RUN, "w0", "zhao2025", "480", str(tmp_path)]
    done = subprocess.run(call, check=True, capture_output=True, text=True)
    half, full, vehicles = map(int, done.stdout.split())
    assert vehicles > 150
    assert full <= 1.05 * half
