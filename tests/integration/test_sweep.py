"""aeb-sumo sweep: one parameter at several values."""

import pytest
from click.testing import CliRunner

import analysis
from aeb_sumo import scenarios
from aeb_sumo.cli import cli
from aeb_sumo.errors import InputError
from aeb_sumo.sweep import sweep


@pytest.mark.slow
def test_a_sweep_runs_the_baseline_and_every_value_with_every_seed(tmp_path):
    done = []
    results = sweep(
        scenarios.load("track"), "staged", "brake_ttc", [0.3, 1.5], seeds=[1, 2], parameters={"warn_ttc": 2.5},
        duration=12.0, workers=2, done=lambda: done.append(1),
    )  # fmt: skip
    assert [(r.runs["strategy"].iloc[0], r.runs["seed"].iloc[0]) for r in results] == [
        ("none", 1), ("none", 2), ("staged", 1), ("staged", 2), ("staged", 1), ("staged", 2),
    ]  # fmt: skip
    assert len(done) == 6
    late, early = (analysis.Dataset.of(r) for r in (results[2], results[4]))
    assert late.interventions["verdict"].tolist() == ["mitigated"]
    assert early.interventions["verdict"].tolist() == ["avoided"]
    assert analysis.precision_recall(early)["recall"].tolist() == [1.0]


@pytest.mark.slow
def test_the_command_prints_and_keeps_the_tables(tmp_path):
    figure, out = tmp_path / "curve.svg", tmp_path / "out"
    done = CliRunner().invoke(
        cli,
        f"sweep track brake_ttc=0.3,1.5 --seeds 1 --duration 12 --workers 2 --out {out} --figure {figure}",
    )
    assert done.exit_code == 0, done.output
    assert "brake_ttc=0.3" in done.output
    assert "precision" in done.output
    assert len(analysis.load(out).runs) == 3
    assert "recall" in figure.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["brake_ttc"], "write NAME=VALUE,VALUE,... with different numbers"),
        (["brake_ttc="], "write NAME=VALUE"),
        (["brake_ttc=1,1"], "write NAME=VALUE"),
        (["brake_ttc=1,x"], "write NAME=VALUE"),
        (["=1,2"], "write NAME=VALUE"),
        (["nope=1,2"], "Staged has no parameter 'nope'"),
        (["brake_ttc=1,99"], "brake_ttc"),
        (["brake_ttc=1", "--verdicts", "none"], "nothing to sweep for"),
        (["brake_ttc=1", "--verdicts", "some"], "verdicts must be all, none or sample:N"),
        (["brake_ttc=1", "--figure", "no/such/folder.svg"], "--figure"),
        (["brake_ttc=1", "--strategy", "nope"], "nope"),
    ],
)
def test_bad_input_is_one_line(arguments, reason):
    done = CliRunner().invoke(cli, ["sweep", "track", *arguments])
    assert isinstance(done.exception, InputError)
    assert reason in str(done.exception)
    assert "\n" not in str(done.exception)
