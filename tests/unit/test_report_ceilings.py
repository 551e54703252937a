import pytest

import analysis
from aeb_sumo.results import Results
from analysis.report.ceilings import section


def dataset(outcomes):
    """One crash of the baseline per outcome of perfect braking."""
    run = {"run_id": "none-1", "strategy": "none", "seed": 1}
    crash = {"run_id": "none-1", "kind": "rear_end"}
    return analysis.Dataset.of(
        Results.of(
            {
                "runs": [run],
                "crashes": [crash | {"crash_id": k} for k in range(len(outcomes))],
                "ceilings": [
                    {"run_id": "none-1", "crash_id": k, "ceiling": "perfect", "outcome": outcome}
                    for k, outcome in enumerate(outcomes)
                ],
            }
        )
    )


def test_crashes_are_shown_by_what_a_ceiling_makes_of_them():
    found = section(
        dataset(["avoided", "avoided", "avoided", "mitigated", "worsened", "unchanged", "other", "unknown"]), []
    )
    (table,) = found.tables
    ((name, crashes, avoided, mitigated, not_, other),) = table.rows
    assert name == "perfect sensor, full braking at once"
    assert [c.value for c in (crashes, mitigated, not_, other)] == [8, 1, 2, 1]
    assert (avoided.value, avoided.n) == (pytest.approx(100 * 3 / 7), 7)


def test_nobody_asked_nothing_is_said():
    assert section(dataset([]), []) is None
