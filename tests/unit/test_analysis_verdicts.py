import numpy as np
import pytest
from statsmodels.stats.proportion import proportion_confint

import analysis
from aeb_sumo.results import VERDICTS, Results


def intervention(verdict, lane="a_0", target="passenger", with_=0.0, without=0.0):
    return {
        "run_id": "x",
        "strategy": "zhao2025",
        "vclass": "passenger",
        "phase": "partial_brake",
        "target_kind": "lead",
        "target_vclass": target,
        "verdict": verdict,
        "lane": lane,
        "with_follower_decel_mps2": with_,
        "without_follower_decel_mps2": without,
    }


def crash(lane, struck, *, equipped=True):
    row = {"run_id": "x", "kind": "rear_end", "secondary": False, "lane": lane, "striker_equipped": equipped}
    row |= {"striker_strategy": "zhao2025" if equipped else "", "striker_vclass": "passenger"}
    return row | {"struck_vclass": struck}


def dataset(interventions, crashes=()):
    run = {"run_id": "x", "scenario": "s", "strategy": "zhao2025", "penetration": 1.0, "seed": 1, "begin_s": 0.0}
    exposure = {"run_id": "x", "vclass": "passenger", "equipped": True, "strategy": "zhao2025", "distance_m": 5e5}
    tables = {"runs": [run | {"end_s": 600.0}], "interventions": interventions}
    return analysis.Dataset.of(Results.of(tables | {"crashes": crashes, "exposure": [exposure]}))


JUDGED = [
    intervention("avoided", "a_0", with_=6.0, without=5.0),
    intervention("avoided", ":j_3_1", "bicycle", with_=6.0),
    intervention("avoided", ":j_12_0", "bicycle"),
    intervention("mitigated"),
    intervention("induced", with_=6.0),
    intervention("precautionary", "a_1"),
    intervention("unneeded", with_=4.0),
    intervention("unneeded"),
    intervention("unneeded", ":j_3_1", "bicycle"),
    intervention("unknown"),
]


@pytest.fixture
def data():
    """Ten verdicts on 500 km; two crashes are left of cars with an AEB, and one of a car without."""
    return dataset(
        JUDGED, [crash("a_0", "passenger"), crash("a_0", "truck", equipped=False), crash(":j_1_0", "bicycle")]
    )


def test_verdicts_are_counted_in_the_order_of_their_definitions(data):
    counts = analysis.verdict_counts(data)["zhao2025"]
    assert list(counts.index) == list(VERDICTS)
    assert counts.to_dict() == dict.fromkeys(VERDICTS, 0) | {
        "avoided": 3, "mitigated": 1, "induced": 1, "precautionary": 1, "unneeded": 3, "unknown": 1,
    }  # fmt: skip
    by_place = analysis.verdict_counts(data, by="place")["zhao2025"]
    assert by_place["junction j", "avoided"] == 2
    assert by_place["a", "unneeded"] == 2


def test_rates_are_per_1000_km_driven_with_an_aeb(data):
    rates = analysis.verdict_rates(data).loc["zhao2025"]
    expected = analysis.poisson_rate(3, 0.5)
    assert tuple(rates.loc["unneeded", ["count", "per_1000_km", "low", "high"]]) == pytest.approx(
        (3, 6.0, expected.low, expected.high)
    )


def test_the_rates_of_a_sample_stand_for_its_share_of_the_distance(data):
    every = analysis.verdict_rates(data).loc["zhao2025", "per_1000_km"]
    thinned = dataset(JUDGED + [intervention("")] * len(JUDGED))
    sampled = analysis.verdict_rates(thinned).loc["zhao2025", "per_1000_km"]
    assert (sampled == 2 * every).all()
    assert np.isnan(analysis.precision_recall(thinned).loc["zhao2025", "recall"])


def test_precision_and_recall(data):
    row = analysis.precision_recall(data).loc["zhao2025"]
    assert row[["judged", "useful", "precautionary", "unneeded", "harmful", "unknown"]].tolist() == [10, 4, 1, 3, 1, 1]
    assert row["precision"] == pytest.approx(4 / 9)
    assert tuple(row[["precision_low", "precision_high"]]) == pytest.approx(proportion_confint(4, 9, method="wilson"))
    assert row["precision_precautionary"] == pytest.approx(5 / 9)
    assert row["struck"] == 2
    assert row["recall"] == pytest.approx(3 / 5)


def test_precision_and_recall_by_target_and_place(data):
    by_target = analysis.precision_recall(data, by="target_vclass").loc["zhao2025"]
    assert by_target.loc["bicycle", "recall"] == pytest.approx(2 / 3)
    assert by_target.loc["passenger", "precision"] == pytest.approx(2 / 6)
    by_place = analysis.precision_recall(data, by="place").loc["zhao2025"]
    assert by_place["judged"].to_dict() == {"a": 7, "junction j": 3}
    assert by_place["struck"].to_dict() == {"a": 1, "junction j": 1}
    by_phase = analysis.precision_recall(data, by="phase").loc["zhao2025"]
    assert np.isnan(by_phase.loc["partial_brake", "recall"])


def test_hard_braking_passed_on_is_what_a_follower_would_not_have_done(data):
    passed = analysis.passed_on(data).loc["zhao2025"]
    assert passed["hard"].to_dict() == {"avoided": 1, "mitigated": 0, "induced": 1, "precautionary": 0, "unneeded": 0}
    assert passed.loc["avoided", "share"] == pytest.approx(1 / 3)


def test_without_verdicts_there_is_nothing_to_say():
    data = dataset([intervention("")])
    assert analysis.verdict_rates(data).empty
    assert analysis.precision_recall(data).empty
    assert analysis.passed_on(data).empty
