"""Laws of the ids of runs."""

import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from aeb_sumo import scenarios
from aeb_sumo.campaign.expansion import expand
from aeb_sumo.campaign.identity import Fitted, content, known, run_id
from aeb_sumo.campaign.settings import Carried, Settings, World
from aeb_sumo.campaign.spec import FACTORS, Common, Spec

W0 = known(scenarios.load("w0"))
FACTOR = {
    "scenario": st.sampled_from(["w0", "b2"]),
    "strategy": st.sampled_from(["none", "staged", "yan2025"]),
    "sensing": st.sampled_from(["radar", "fusion"]),
    "penetration": st.sampled_from([0.1, 0.5, 1.0]),
    "demand": st.sampled_from([0.5, 1.5]),
    "mu": st.sampled_from([0.3, 0.7]),
    "seed": st.integers(0, 2**31 - 1),
}
SPECS = st.fixed_dictionaries(
    {name: st.lists(FACTOR[name], min_size=1, max_size=2, unique=True).map(tuple) for name in ("scenario", "strategy")},
    optional={
        name: st.lists(values, min_size=1, max_size=2, unique=True).map(tuple)
        for name, values in FACTOR.items()
        if name not in ("scenario", "strategy")
    },
)

SETTINGS = st.builds(
    Settings,
    world=st.just(World(root="/", scenario="w0")),
    carried=st.builds(Carried, strategy=st.just("staged"), penetration=st.floats(0, 1)),
    seed=st.integers(0, 2**31 - 1),
    duration_s=st.floats(1, 1e5),
    step_length_s=st.floats(0.01, 1),
    blockage_s=st.none() | st.floats(0, 90),
    interval_s=st.floats(1, 1e4),
    verdicts=st.sampled_from(["none", "all", "sample:3"]),
)


def ids(factors):
    return [job.run_id for job in expand(Spec(path=Path("/spec.toml"), factors=factors, common=Common(duration_s=5.0)))]


@given(SPECS, st.randoms(use_true_random=False))
def test_the_order_in_which_things_are_written_means_nothing(factors, random):
    names = list(factors)
    random.shuffle(names)
    shuffled = {name: tuple(random.sample(factors[name], len(factors[name]))) for name in names}
    assert sorted(ids(factors)) == sorted(ids(shuffled))


@given(SPECS, st.sampled_from(sorted(FACTOR)), st.data())
def test_a_value_more_adds_runs_and_takes_none_away(factors, name, data):
    if name not in factors:
        return
    more = data.draw(FACTOR[name])
    larger = factors | {name: tuple(dict.fromkeys((*factors[name], more)))}
    before, after = ids(factors), ids(larger)
    assert set(before) <= set(after)
    baseline_only = factors["strategy"] == ("none",) and name in ("sensing", "penetration")
    assert (len(after) > len(before)) == (more not in factors[name] and not baseline_only)


@given(SETTINGS, SETTINGS)
def test_two_runs_have_one_id_if_and_only_if_they_are_the_same(one, two):
    def made(settings):
        carried = Fitted(settings.carried.make())
        made_of = content(W0, carried, settings)
        assert json.loads(json.dumps(made_of)) == made_of
        return run_id(W0, carried, settings.seed, made_of)

    assert made(one) == made(replace(one))
    assert (made(one) == made(two)) == (one == two)


def test_every_part_of_what_a_run_is_made_of_is_in_its_id():
    carried = Fitted(Carried(strategy="staged").make())
    settings = Settings(
        world=World(root="/", scenario="w0"), carried=Carried(strategy="staged"), seed=1, duration_s=5.0,
        step_length_s=0.1, blockage_s=None, interval_s=60.0, verdicts="none",
    )  # fmt: skip
    made_of = content(W0, carried, settings)
    found = {run_id(W0, carried, 1, made_of | {key: "other"}) for key in made_of}
    assert len(found) == len(made_of)
    assert run_id(W0, carried, 1, made_of) not in found


def test_every_factor_of_a_specification_changes_the_id():
    values = {
        "scenario": ("w0", "b2"), "strategy": ("staged", "yan2025"), "sensing": ("radar", "fusion"),
        "penetration": (0.5, 1), "demand": (1, 2), "ebike_share": (0.1, 0.2), "weather": ("dry", "wet"),
        "mu": (0.3, 0.7), "drivers": ("intersection", "careful"), "seed": (1, 2),
    }  # fmt: skip
    assert values.keys() == FACTORS.keys() - {"equip"}
    for name, pair in values.items():
        factors = {"scenario": ("w0",), "strategy": ("staged",)} | {name: pair}
        for one, two in pairwise(ids(factors)):
            assert one.rpartition("-")[2] != two.rpartition("-")[2], name


def test_options_of_a_scenario_are_in_its_ids():
    w0 = W0.scenario
    other = known(replace(w0, options=(*w0.options, "--time-to-teleport", "-1")))
    assert W0.made_of["options"] == {"lateral-resolution": "0.35", "time-to-teleport": "90"}
    assert other.made_of["options"] == {"lateral-resolution": "0.35", "time-to-teleport": "-1"}
    assert other.teleport_after == float("inf")
    short = tuple({"--net-file": "-n", "--additional-files": "-a"}.get(word, word) for word in w0.options)
    assert known(replace(w0, options=short)).made_of == W0.made_of
