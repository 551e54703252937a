"""The control surfaces against `skfuzzy.control`: python tests/benchmarks/fuzzy.py. Building is timed on its own."""

import sys
from pathlib import Path
from time import perf_counter

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))
from aeb_sumo.strategies import zhao2025, zheng2020
from tests.reference.test_fuzzy import infer, simulation

POINTS, SINGLES, ARRAYS = 1000, 10, 200


def main():
    for module in (zhao2025, zheng2020):
        base = module.rule_base()
        begin = perf_counter()
        surface = base.surface()
        building = perf_counter() - begin
        rng = np.random.default_rng(1)
        x, y = rng.uniform(*base.x_range, POINTS), rng.uniform(*base.y_range, POINTS)

        error = np.abs(surface(x, y) - infer(simulation(base), x, y)).max()

        system, single = simulation(base), []
        for point in zip(x[:SINGLES], y[:SINGLES], strict=True):
            begin = perf_counter()
            infer(system, *point)
            single.append(perf_counter() - begin)

        begin = perf_counter()
        for _ in range(ARRAYS):
            surface(x, y)
        fast = (perf_counter() - begin) / ARRAYS / POINTS

        slow = np.median(single)
        print(f"{module.__name__.rpartition('.')[2]}, rules {base.rules.shape}, grid {surface.values.shape}")
        print(f"  building the surface               {building:8.2f} s")
        print(f"  largest error at {POINTS} random points {error:8.4f} m/s2")
        print(f"  skfuzzy.control, one inference     {slow * 1e3:8.1f} ms")
        print(f"  surface, one of {POINTS} in an array    {fast * 1e9:8.0f} ns, {slow / fast:,.0f} times faster")


if __name__ == "__main__":
    main()
