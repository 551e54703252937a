import pytest

from aeb_sumo.replay.event import find
from aeb_sumo.results import Results, write

RUN = {
    "scenario": "track", "sensing": "ideal", "parameters": "", "penetration": 1.0, "seed": 1, "drivers": "robots",
    "step_length_s": 0.1, "begin_s": 0.0, "end_s": 60.0, "demand": 1.0, "weather": "", "mu": 0.85, "blockage_s": 60.0,
}  # fmt: skip
CRASH = {"crash_id": 0, "time_s": 50.0, "striker": "a", "struck": "b"}


def run_of(run_id, strategy="zhao2025", **changes):
    sensing = {} if strategy != "none" else {"sensing": "", "penetration": 0.0}
    return RUN | sensing | {"run_id": run_id, "strategy": strategy} | changes


def acted(number, vehicle, target, begin, end, run_id="x"):
    return {
        "run_id": run_id, "intervention_id": number, "vehicle": vehicle, "target": target, "begin_s": begin,
        "end_s": end,
    }  # fmt: skip


@pytest.fixture
def folder(tmp_path):
    """Writes runs; crashes and interventions go with the first."""

    def make(runs, interventions=()):
        for run in runs:
            own = {"runs": [run]}
            if run is runs[0]:
                own |= {"crashes": [CRASH | {"run_id": run["run_id"]}], "interventions": list(interventions)}
            write(Results.of(own), tmp_path)
        return tmp_path

    return make


ON_ANOTHER, ON_EACH_OTHER, LONG_AGO = (
    acted(0, "a", "c", 48.0, 49.5), acted(1, "b", "a", 45.0, 47.0), acted(2, "a", "b", 30.0, 39.9),
)  # fmt: skip
BYSTANDERS = [acted(3, "c", "a", 49.0, 49.9), acted(4, "a", "b", 50.1, 51.0)]


@pytest.mark.parametrize(
    ("interventions", "ego"),
    [
        ([ON_ANOTHER, ON_EACH_OTHER, LONG_AGO, *BYSTANDERS], "b"),
        ([ON_ANOTHER, LONG_AGO, *BYSTANDERS], "a"),
        ([ON_EACH_OTHER, acted(5, "a", "b", 49.0, 49.9)], "a"),
    ],
)
def test_a_crash_goes_with_the_last_intervention_of_the_two_first_on_each_other(folder, interventions, ego):
    event = find(folder([run_of("x")], interventions), "crash:0")
    assert event.intervention is not None
    assert event.ego == ego
    assert {event.ego, event.other} == {"a", "b"}


def test_one_that_was_over_long_before_or_came_after_or_is_another_s_is_none_of_it(folder):
    event = find(folder([run_of("x")], [LONG_AGO, *BYSTANDERS]), "crash:0")
    assert event.intervention is None
    assert (event.ego, event.other) == ("a", "b")


def test_the_aeb_of_the_other_world_is_that_of_the_other_group_of_the_same_seed(folder):
    others = [run_of("y", "staged", seed=2, sensing="fusion"), run_of("z", "lin2021", parameters="brake.lag=0.3")]
    event = find(folder([run_of("x", "none"), *others]), "crash:0", "x")
    assert event.system.name == "lin2021"
    assert event.system.strategy.brake.lag == 0.3


def test_the_run_s_own_aeb_comes_first(folder):
    assert find(folder([run_of("x", "staged", sensing="fusion"), run_of("y")]), "crash:0").system.name == "staged"


def test_a_baseline_alone_is_set_against_zhao2025(folder):
    assert find(folder([run_of("x", "none")]), "crash:0").system.name == "zhao2025"
