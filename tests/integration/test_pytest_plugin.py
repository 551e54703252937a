"""The plugin as a user meets it: in a pytest of its own, in a folder of its own."""

import re

import pytest

from aeb_sumo.pytest_plugin import Golden

Failed = pytest.fail.Exception

TEST = """
from aeb_sumo.strategies.zhao2025 import Zhao2025

def test_it(aeb_golden):
    results = aeb_golden("track", {strategy}, duration=20)
    assert len(results.runs) == 1
"""
OTHER = '\n["another run"]\nvehicles = 7\n"crash of é with b" = {time_s = 1.0}\n'


@pytest.fixture
def check(pytester):
    """Writes the user's test of a strategy and runs pytest over it, warnings being errors."""

    def check(strategy, *options, test=TEST):
        pytester.makepyfile(test_mine=test.format(strategy=strategy))
        return pytester.runpytest_subprocess("-W", "error", *options)

    return check


@pytest.fixture
def table(pytester):
    return pytester.path / "test_mine.golden.toml"


def test_from_the_first_run_to_a_changed_strategy(check, table):
    first = check("'zhao2025'")
    first.assert_outcomes(failed=1)
    first.stdout.fnmatch_lines(["no golden numbers of 'track zhao2025 duration=20' yet: run `pytest --update-golden`*"])
    assert not table.exists()

    table.write_text(OTHER, encoding="utf-8")
    check("'zhao2025'", "--update-golden").assert_outcomes(passed=1)
    written = table.read_text(encoding="utf-8")
    assert OTHER in written
    assert '"intervention 1 of ego" = {phase = "partial_brake", target = "lead", begin_s = 2.1, brake_s = ' in written
    check("'zhao2025'").assert_outcomes(passed=1)

    changed = check("Zhao2025(comfort_decel=5.0)")
    changed.assert_outcomes(failed=1)
    changed.stdout.re_match_lines(
        [
            r"'track zhao2025 duration=20' moved; .*`pytest --update-golden` \(.*test_mine.golden.toml\)",
            r"  first_braking_s: 3\.\d{3} -> 3\.\d{3}",
            r"  intervention 1 of ego: brake_s: \d\.\d{3} -> \d\.\d{3}",
        ]
    )
    changed.stdout.no_re_match_line("  (vehicles|.*begin_s)")
    assert table.read_text(encoding="utf-8") == written

    check("Zhao2025(comfort_decel=5.0)", "--update-golden").assert_outcomes(passed=1)
    assert OTHER in table.read_text(encoding="utf-8") != written


@pytest.mark.slow
def test_workers_share_a_table(check, table):
    test = "\n".join(
        f"def test_{n}(aeb_golden):\n    aeb_golden('track', 'none', name='run {n}', duration=1)" for n in range(4)
    )
    check("", "--update-golden", "-n", "2", test=test).assert_outcomes(passed=4)
    assert [line for line in table.read_text().splitlines() if line.startswith("[")] == [
        f'["run {n}"]' for n in range(4)
    ]
    check("", "-n", "2", test=test).assert_outcomes(passed=4)


def test_costs_nothing_until_used(check):
    test = (
        "import sys\n"
        "def test_it():\n"
        "    assert 'aeb_sumo.pytest_plugin' in sys.modules\n"
        "    assert not {'libsumo', 'pandas', 'numpy'} & sys.modules.keys()"
    )
    check("", test=test.replace("{", "{{").replace("}", "}}")).assert_outcomes(passed=1)
    check("", "-p", "no:aeb_sumo", test="def test_it(): pass").assert_outcomes(passed=1)


@pytest.fixture
def golden(tmp_path):
    """Runs the track with AEB, in this process, and compares with a table that was written the same way."""

    def golden(*call, update=False, **arguments):
        table = Golden(path=tmp_path / "t.golden.toml", update=update)
        return table(*(call or ("track", "zhao2025")), **{"duration": 10, **arguments})

    golden.table = tmp_path / "t.golden.toml"
    golden(update=True)
    return golden


def change(table, old, new):
    text = table.read_text(encoding="utf-8")
    assert old in text
    table.write_text(text.replace(old, new), encoding="utf-8")


def test_an_event_that_comes_or_goes_is_one_line(golden):
    change(golden.table, "1 of ego", "1 of somebody")
    with pytest.raises(Failed) as failure:
        golden()
    gone, new = str(failure.value).splitlines()[1:]
    assert re.fullmatch(r"  intervention 1 of somebody: \{phase = .*\} -> none", gone)
    assert re.fullmatch(r"  intervention 1 of ego: none -> \{phase = .*\}", new)


def test_tolerance_is_for_measures_not_for_counts(golden):
    change(golden.table, "begin_s = 2.1,", "begin_s = 2.102,")
    with pytest.raises(Failed, match=r"begin_s: 2\.102 -> 2\.100"):
        golden()
    golden(tolerance=0.002)
    change(golden.table, "vehicles = 2", "vehicles = 3")
    with pytest.raises(Failed, match=r"\n  vehicles: 3 -> 2$"):
        golden(tolerance=5)


def test_runs_have_names(golden):
    golden("track", "none", update=True, penetration=0.5, duration=5.0)
    golden("track", "none", update=True, duration=5, name="mine")
    assert [line for line in golden.table.read_text(encoding="utf-8").splitlines() if line.startswith("[")] == [
        '["mine"]',
        '["track none duration=5 penetration=0.5"]',
        '["track zhao2025 duration=10"]',
    ]


@pytest.mark.parametrize("update", [False, True])
@pytest.mark.parametrize(
    "content", [b"vehicles = ", b"vehicles = 2", b"\xff"], ids=["syntax", "no section", "encoding"]
)
def test_unreadable_table(golden, content, update):
    golden.table.write_bytes(content)
    with pytest.raises(Failed, match=rf"^cannot read {re.escape(str(golden.table))}: [^\n]*$"):
        golden(update=update)
    assert golden.table.read_bytes() == content


def test_unwritable_table(golden):
    golden.table.with_name(".t.golden.toml.partial").mkdir()
    with pytest.raises(Failed, match=f"^cannot write {re.escape(str(golden.table))}: Is a directory$"):
        golden(update=True)


@pytest.mark.parametrize(
    ("call", "arguments", "message"),
    [
        (("nowhere",), {}, "scenario.*nowhere"),
        (("track", "nothing"), {}, "strategy.*nothing"),
        (("no.sumocfg",), {}, r"no\.sumocfg"),
        (("track",), {"penetration": 2}, r"penetration must lie within 0\.\.1, not 2"),
    ],
)
def test_bad_usage_gives_one_line(golden, call, arguments, message):
    with pytest.raises(Failed, match=rf"^[^\n]*{message}[^\n]*$") as failure:
        golden(*call, **arguments)
    assert failure.value.__suppress_context__
