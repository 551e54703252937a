"""What a verdict costs: CPU time per intervention on the highway, and against bare SUMO.

    python tests/benchmarks/verdicts.py [SECONDS]

The highway with zhao2025 in every car and about 200 vehicles, 300 s unless said otherwise. Three runs of the same seed:
bare SUMO that reads nothing, without verdicts, and with a verdict for every intervention. The cost of the verdicts is
what the last takes more than the second, forks and all.
"""

import resource
import sys
import time

from aeb_sumo import scenarios
from aeb_sumo.simulate import run
from aeb_sumo.world.session import IMPOSED, Session

DEMAND = 1.35  # times the scenario's: 200 vehicles on average


def spent() -> float:
    """CPU time of this process and of its children that have ended [s]."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def main() -> None:
    duration = float(sys.argv[1]) if len(sys.argv) > 1 else 300.0
    scenario = scenarios.load("highway").varied(demand=DEMAND)
    run(scenario, "zhao2025", duration=1)  # what is prepared once does not count
    start = spent()
    with Session([*scenario.sumo_options, *IMPOSED, "--step-length", "0.1", "--seed", "1"]) as session:
        while session.time < duration:
            session.step()
    bare = spent() - start
    costs = {}
    for verdicts in ("none", "all"):
        start = spent()
        result = run(scenario, "zhao2025", seed=1, duration=duration, verdicts=verdicts)
        costs[verdicts] = spent() - start
    judged = result.interventions
    forked = int((judged["acted_by"] != "").sum())
    vehicles = result.exposure["time_s"].sum() / duration
    each = (costs["all"] - costs["none"]) / len(judged)
    print(f"{vehicles:.0f} vehicles on average, {len(judged)} interventions, {forked} of them acted on the world")
    print(f"run without verdicts: {costs['none']:.1f} s, {costs['none'] / bare:.2f} times bare SUMO ({bare:.1f} s)")
    print(f"verdicts: {costs['all'] - costs['none']:.1f} s, {each:.3f} s per intervention,")
    print(
        f"  {each / (bare / duration * 10):.2f} times 10 s of bare SUMO; the run: {costs['all'] / bare:.2f} times bare"
    )
    print(judged["verdict"].value_counts().to_string())


if __name__ == "__main__":
    main()
