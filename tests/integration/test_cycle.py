"""A system that works more slowly than the simulation."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from aeb_sumo.scenarios.cases import EGO, approach
from aeb_sumo.simulate import run
from aeb_sumo.strategies.base import Demand, Phase, Strategy
from aeb_sumo.strategies.none import Nothing
from aeb_sumo.strategies.zhao2025 import Zhao2025
from aeb_sumo.trace import Trace


@dataclass(frozen=True, kw_only=True)
class Counter(Strategy):
    """Warns in every second step of its own, and of nothing."""

    name: ClassVar[str] = "counter"
    source: ClassVar[str] = "this test"

    @property
    def cycle(self):
        return 0.04

    def init(self, n):
        return Nothing(np.zeros(n, np.bool_))

    def step(self, state, percept, dt):
        assert len(percept.gap) > 0
        assert dt >= 0.04
        phase = np.where(percept.valid & ~state.unused, Phase.WARN, Phase.NONE)
        return Nothing(~state.unused), Demand(phase=phase.astype(np.int64), decel=np.zeros(len(phase)))


@pytest.mark.parametrize(("dt", "rate"), [(0.01, 25), (0.02, 25), (0.03, 25), (0.05, 20), (0.1, 10)])
def test_rate(dt, rate):
    trace = Trace(EGO)
    road = approach("following", ego=11.0, lead=10.0, gap=6.5, step_length=dt, duration=4.5)
    run(road, Counter(), trace=trace)
    phase = trace.frame().set_index("time_s")["phase"].loc[1.0:3.999]
    assert np.count_nonzero(np.diff(phase)) / 3 == pytest.approx(rate, abs=0.7)


def test_a_demand_is_not_held_for_a_target_that_is_gone():
    """A slow system, and a lead that drives off the end of its road in front of it."""
    trace = Trace(EGO)
    road = approach("gone", ego=25.0, lead=20.0, gap=5.0, step_length=0.02, duration=3.0)
    routes = road.routes.replace(
        'id="target" type="car" route="ahead"', 'id="target" type="car" route="ahead" arrivalPos="615"'
    )
    run(replace(road, routes=routes), Zhao2025(sampling=0.5), trace=trace)
    frame = trace.frame()
    gone = frame["target"].eq("") & frame["target"].shift(fill_value="").ne("")
    assert gone.any()
    assert (frame.loc[gone, "phase"] == Phase.NONE).all()
