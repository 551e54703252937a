from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aeb_sumo.errors import InputError
from aeb_sumo.results import VERDICTS
from aeb_sumo.verdicts import Choice, Hit, Outcome, verdict
from aeb_sumo.verdicts.choice import Reservoir


def hit(speed, risk=None, *, own=True, pair=("a", "ego")):
    return Hit(pair=pair, own=own, impact_speed=speed, delta_v=speed / 2, serious_risk=risk)


def crash(*hits, **values):
    return Outcome(hits=hits, **values)


NOTHING = Outcome()


@pytest.mark.parametrize(
    ("with_", "without", "expected"),
    [
        (NOTHING, crash(hit(5.0)), "avoided"),
        (NOTHING, crash(hit(0.1)), "avoided"),
        (crash(hit(5.0)), NOTHING, "induced"),
        (crash(hit(5.0), near_crash=True), Outcome(near_crash=True), "induced"),
        (crash(hit(5.0)), crash(hit(8.0)), "mitigated"),
        (crash(hit(8.0)), crash(hit(5.0)), "worsened"),
        (crash(hit(5.0)), crash(hit(5.0)), "unchanged"),
        (crash(hit(5.0, 0.1)), crash(hit(5.2, 0.12)), "unchanged"),  # 0.2 m/s are nothing
        (crash(hit(5.0)), crash(hit(5.3)), "mitigated"),
        # Hitting a rider at 8 m/s is worse than being hit from behind at 9.
        (crash(hit(9.0, 0.01, pair=("c", "ego"))), crash(hit(8.0, 0.4, pair=("ego", "rider"))), "mitigated"),
        (crash(hit(8.0, 0.4, pair=("ego", "rider"))), crash(hit(9.0, 0.01, pair=("c", "ego"))), "worsened"),
        (crash(hit(9.0, None, pair=("c", "ego"))), crash(hit(8.0, 0.4, pair=("ego", "rider"))), "worsened"),
        (NOTHING, Outcome(near_crash=True), "precautionary"),
        (Outcome(near_crash=True), NOTHING, "unneeded"),
        (NOTHING, Outcome(pet=0.9), "precautionary"),
        (NOTHING, Outcome(pet=1.1), "unneeded"),
        (NOTHING, NOTHING, "unneeded"),
    ],
)
def test_the_verdict_is(with_, without, expected):
    assert verdict(with_, without) == expected


def test_a_crash_behind_counts_only_if_the_intervention_changed_it():
    behind = hit(6.0, own=False, pair=("b", "c"))
    assert verdict(crash(behind), crash(behind)) == "unneeded"
    assert verdict(crash(behind), NOTHING) == "induced"
    assert verdict(NOTHING, crash(behind)) == "avoided"
    assert verdict(crash(behind), crash(behind, hit(5.0))) == "avoided"
    assert verdict(crash(behind), crash(hit(9.0, own=False, pair=("b", "c")))) == "mitigated"


OUTCOMES = st.builds(
    Outcome,
    hits=st.lists(
        st.builds(
            Hit,
            pair=st.sampled_from([("a", "ego"), ("b", "ego"), ("b", "c")]),
            own=st.booleans(),
            impact_speed=st.floats(0, 40),
            delta_v=st.just(1.0),
            serious_risk=st.none() | st.floats(0, 1),
        ),
        max_size=3,
    ).map(tuple),
    near_crash=st.booleans(),
    pet=st.floats(0, 5),
)


@given(OUTCOMES, OUTCOMES)
def test_exchanging_the_worlds_exchanges_the_verdict(one, other):
    opposite = {"avoided": "induced", "mitigated": "worsened", "unchanged": "unchanged"}
    opposite |= {b: a for a, b in opposite.items()}
    there, back = verdict(one, other), verdict(other, one)
    assert there in VERDICTS
    assert opposite.get(there, "no crash") == (back if there in opposite else "no crash")
    if there not in opposite:
        assert {there, back} <= {"precautionary", "unneeded"}


@given(OUTCOMES)
def test_worlds_that_are_the_same_are_unchanged_or_without_crash(one):
    assert verdict(one, one) in {"unchanged", "precautionary", "unneeded"}


def test_a_choice_is_all_none_or_a_sample():
    assert Choice.parse("all").size == float("inf")
    assert Choice.parse("none").size == 0
    assert Choice.parse("sample:20").size == 20


@pytest.mark.parametrize("text", ["", "some", "sample", "sample:", "sample:0", "sample:-3", "sample:1.5", "All", "7"])
def test_another_choice_is_refused_in_one_line(text):
    with pytest.raises(InputError, match="verdicts must be all, none or sample:N") as refused:
        Choice.parse(text)
    assert "\n" not in str(refused.value)


def sample(size, among, seed):
    reservoir, kept = Reservoir(size, seed), set()
    for number in range(among):
        placed, loser = reservoir.offer()
        kept -= {loser}
        kept |= {number} if placed else set()
    return kept


def test_a_reservoir_keeps_as_many_as_it_should():
    assert sample(5, 3, 1) == {0, 1, 2}
    assert len(sample(5, 100, 1)) == 5
    assert sample(5, 100, 1) == sample(5, 100, 1)
    assert sample(5, 100, 1) != sample(5, 100, 2)
    assert sample(float("inf"), 100, 1) == set(range(100))


def test_all_have_the_same_chance_of_a_place():
    times = Counter(number for seed in range(3000) for number in sample(4, 20, seed))
    expected = 3000 * 4 / 20
    assert all(abs(times[n] - expected) < 5 * (expected * 0.8) ** 0.5 for n in range(20))
