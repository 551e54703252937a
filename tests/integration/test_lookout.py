import numpy as np
import pytest

from aeb_sumo.candidates import Candidates
from aeb_sumo.lookout import Lookout
from aeb_sumo.perception.suites import suite
from aeb_sumo.strategies.base import Gaze
from aeb_sumo.world.buildings import walls
from aeb_sumo.world.footpaths import Footpaths
from aeb_sumo.world.leads import Leads
from aeb_sumo.world.network import Network
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.paths import Paths
from aeb_sumo.world.session import IMPOSED, Session
from aeb_sumo.world.sightlines import Sightlines
from aeb_sumo.world.walkers import Walkers
from tests.helpers import approach


def targets(options, sensing, unnamed, steps=30):
    """The ego's target in each step, '' for none, where SUMO does not name its lead in the steps `unnamed`."""
    with Session([*options, *IMPOSED, "--step-length", "0.1"]) as session:
        t, network = Traffic(session.dt), Network()
        leads, paths = Leads(t, cycle=t.dt, horizon=5.0), Paths(t, network)
        footpaths, eyes = Footpaths(t, paths, Walkers(t, network)), suite(sensing)
        candidates = Candidates(t, leads, paths, footpaths, Sightlines(t, walls()), eyes, Gaze.PATH)
        lookout = Lookout(t, candidates, eyes, Gaze.PATH, sublane=False, seed=1)
        seen = []
        for step in range(steps):
            session.step()
            t.observe()
            leads.step(np.zeros(0, np.int64), np.zeros(0, np.int64))
            paths.step()
            ego = t.slot["ego"]
            t.follow(t.present)
            leads.possible[ego] = step not in unnamed
            leads.known[ego] = not {step, step - 1} & unnamed
            who, found = lookout.step(np.array([ego]), braking=np.zeros(t.capacity, bool), time=session.time)
            seen.append(t.ids[found.slot[0]] if len(who) else "")
    return seen


@pytest.mark.parametrize("sensing", ["ideal", "fusion"])
def test_a_lead_that_sumo_does_not_name_for_a_moment_keeps_its_track(on_track, sensing):
    options = on_track(approach(40, 20, 40)).options
    always = targets(options, sensing, set())
    assert always[10:] == ["lead"] * 20
    for pause in ({15}, {15, 16}):
        assert targets(options, sensing, pause) == ["" if k in pause else who for k, who in enumerate(always)]
    late = targets(options, sensing, {15, 16, 17, 18, 19})
    assert late[20] == ""
    assert late[25:] == ["lead"] * 5
