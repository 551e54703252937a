"""What a campaign's specification stands for."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import sumo_nets
from aeb_sumo.campaign.expansion import expand
from aeb_sumo.campaign.failure import row_of
from aeb_sumo.campaign.identity import differences
from aeb_sumo.campaign.settings import Settings
from aeb_sumo.campaign.spec import read
from aeb_sumo.errors import InputError
from aeb_sumo.repeat import settings
from tests.helpers import command

MINIMAL = """[factors]
scenario = ["w0", "highway"]
strategy = ["none", "zhao2025"]
seed = [1, 2, 3, 4]
[run]
duration_s = 60
"""


@pytest.fixture
def jobs(tmp_path):
    """Runs of a specification in text."""

    def make(text, name="spec.toml"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return expand(read(path))

    return make


def readable(job):
    """Its id without the digest."""
    return job.run_id.rpartition("-")[0]


def test_the_minimal_specification_is_sixteen_runs_with_ids_that_can_be_read(jobs):
    found = jobs(MINIMAL)
    assert len({job.run_id for job in found}) == 16
    assert [readable(job) for job in found[:4]] == [
        "w0-none-p0-s1", "w0-zhao2025-p1-s1", "highway-none-p0-s1", "highway-zhao2025-p1-s1",
    ]  # fmt: skip
    assert {job.settings.duration_s for job in found} == {60.0}


def test_the_baseline_is_not_multiplied_by_what_means_nothing_to_it(jobs):
    found = jobs(
        '[factors]\nscenario = "w0"\nstrategy = ["none", "staged"]\nsensing = ["radar", "fusion"]\n'
        "penetration = [0.1, 0.5, 1]\nseed = 1\n[set.staged]\nbrake_ttc = [0.5, 0.9]\n"
    )
    assert [readable(job) for job in found].count("w0-none-p0-s1") == 1
    assert len(found) == 1 + 2 * 3 * 2
    assert {job.content["parameters"] for job in found} == {"", "brake_ttc=0.5", "brake_ttc=0.9"}


def test_a_mix_stands_beside_strategies(jobs):
    found = jobs(
        '[factors]\nscenario = "w0"\nstrategy = "none"\nequip = ["zhao2025=0.3,yan2025=0.2"]\n'
        "[set]\nyan2025.brake.lag = 0.2\n"
    )
    assert [job.content["strategy"] for job in found] == ["none", "yan2025=0.2,zhao2025=0.3"]
    assert found[1].content["parameters"] == "yan2025.brake.lag=0.2"


def test_the_same_run_said_in_two_ways_is_one(jobs):
    found = jobs('[factors]\nscenario = "w0"\nstrategy = "zhao2025"\nequip = "zhao2025=1"\npenetration = 1\n')
    assert len(found) == 1


def test_what_is_said_like_the_default_is_the_default(jobs):
    short = jobs('[factors]\nscenario = "w0"\nstrategy = "zhao2025"\n')
    long = jobs(
        '[factors]\nscenario = ["w0"]\nstrategy = "zhao2025"\nsensing = "ideal"\npenetration = 1\nseed = 1\n'
        '[run]\nduration_s = 1800\nstep_length_s = 0.1\ninterval_s = 60\nverdicts = "none"\nlimit_s = 7\n'
    )
    assert [job.run_id for job in short] == [job.run_id for job in long]


def test_all_variations_of_a_scenario_are_crossed(jobs):
    found = jobs(
        '[factors]\nscenario = ["w0", "b2"]\nstrategy = "none"\ndemand = [0.5, 1.5]\nebike_share = [0.2, 0.4]\n'
        'weather = ["dry", "wet"]\ndrivers = ["intersection", "careful"]\nseed = "3..5"\n'
    )
    assert len({job.run_id for job in found}) == 2**5 * 3
    assert readable(found[0]) == "w0-demand0.5-ebikes0.2-dry-intersection-none-p0-s3"
    assert [job.settings.seed for job in found] == sorted(job.settings.seed for job in found), (
        "the seed changes slowest"
    )


def test_settings_survive_the_way_to_a_worker(jobs):
    for job in jobs('[factors]\nscenario = "w0"\nequip = "zhao2025=0.5"\n[set]\nzhao2025.comfort_decel = 5\n'):
        assert Settings.of(json.loads(json.dumps(job.settings.plain()))) == job.settings
        assert not differences(job.content, json.loads(json.dumps(job.content)))


def test_a_run_is_repeated_by_its_row_in_spite_of_its_id(jobs):
    found = jobs(
        '[factors]\nscenario = "w0"\nstrategy = ["none", "staged"]\npenetration = 0.25\ndemand = 1.3\n'
        'ebike_share = 0.4\nmu = 0.6\ndrivers = "careful"\nseed = 5\n[set]\nstaged.brake_ttc = 0.5\n[run]\n'
        "duration_s = 20\nblockage_s = 30\n"
    )
    for job in found:
        row = {**row_of(job.run_id, job.settings, ""), "begin_s": 0.0, "end_s": 20.0}
        again = settings(row)
        assert again.scenario == job.settings.world.make()
        assert again.equip == job.settings.carried.make()
        assert (again.seed, again.duration, again.blockage) == (5, 20.0, 30.0)


def test_ids_are_names_of_files(tmp_path):
    name = "_" + "é" * 110
    own(tmp_path / "net", name=name)
    (found,) = ids_in(tmp_path / "net", tmp_path, f'[factors]\nscenario = "net/{name}.sumocfg"\nstrategy = "none"\n')
    assert len(found.encode()) < 230
    assert found[0] == "é"


def own(folder, name="city"):
    """A scenario of one's own in a folder."""
    folder.mkdir(parents=True)
    shutil.copy(sumo_nets.folder("track") / "track.net.xml", folder / "net.xml")
    (folder / "r.rou.xml").write_text('<routes><trip id="t" depart="1" from="track" to="track"/></routes>')
    (folder / "a.add.xml").write_text('<additional><include href="b.add.xml"/></additional>')
    (folder / "b.add.xml").write_text("<additional/>")
    (folder / f"{name}.sumocfg").write_text(
        '<configuration><net-file value="net.xml"/><route-files value="r.rou.xml"/>'
        '<additional-files value="a.add.xml"/><end value="5"/><seed value="7"/>'
        '<tripinfo-output value="trips.xml"/></configuration>'
    )
    return folder


def ids_in(folder, tmp_path, text='[factors]\nscenario = "net/city.sumocfg"\nstrategy = "none"\n'):
    path = folder.parent / "spec.toml"
    path.write_text(text)
    return [job.run_id for job in expand(read(path))]


def test_an_id_does_not_depend_on_where_the_files_lie(tmp_path):
    one, two = (ids_in(own(tmp_path / name / "net"), tmp_path) for name in ("here", "elsewhere/deep"))
    assert one == two
    assert one[0].startswith("city-none-p0-s7-"), "the seed is that of the configuration"


def test_what_sumo_wrote_there_before_changes_no_id(tmp_path):
    folder = own(tmp_path / "net")
    before = ids_in(folder, tmp_path)
    (folder / "trips.xml").write_text("<tripinfos/>")
    assert ids_in(folder, tmp_path) == before


@pytest.mark.parametrize("name", ["net.xml", "r.rou.xml", "a.add.xml", "b.add.xml", "city.sumocfg"])
def test_a_file_that_changes_changes_the_id(tmp_path, name):
    folder = own(tmp_path / "net")
    before = ids_in(folder, tmp_path)
    with (folder / name).open("a") as file:
        file.write("<!-- other -->")
    assert ids_in(folder, tmp_path) != before


def test_a_profile_that_changes_changes_the_id_but_its_place_does_not(tmp_path):
    text = '[factors]\nscenario = "w0"\nstrategy = "none"\ndrivers = "PLACE/mine.toml"\n'
    found = {}
    for place, share in (("a", 0.2), ("b", 0.2), ("c", 0.3)):
        (tmp_path / place).mkdir()
        (tmp_path / place / "mine.toml").write_text(f"[glances]\nshare = {share}\n")
        (found[place],) = ids_in(tmp_path / place, tmp_path, text.replace("PLACE", place))
    assert found["a"] == found["b"] != found["c"]


def test_files_that_include_each_other_come_to_an_end(tmp_path):
    folder = own(tmp_path / "net")
    for name in ("a", "b"):
        text = '<additional><include href="a.add.xml"/><include href="b.add.xml"/></additional>'
        (folder / f"{name}.add.xml").write_text(text)
    assert len(ids_in(folder, tmp_path)) == 1


def test_ids_are_the_same_in_another_process(jobs, tmp_path):
    here = [job.run_id for job in jobs(MINIMAL)]
    code = (
        "import sys; from pathlib import Path; from aeb_sumo.campaign.spec import read;"
        "from aeb_sumo.campaign.expansion import expand;"
        "print(*(job.run_id for job in expand(read(Path(sys.argv[1])))))"
    )
    for hashing in ("1", "2"):
        done = subprocess.run(
            [sys.executable, "-c", code, "spec.toml"], cwd=tmp_path, check=True, capture_output=True, text=True,
            env={**os.environ, "PYTHONHASHSEED": hashing},
        )  # fmt: skip
        assert done.stdout.split() == here


WRONG = [
    ("", "[factors] needs scenario"),
    ("[factors]\nscenario = 'w0'\n", "[factors] needs strategy or equip"),
    ("[factor]\n", "factor is unknown; allowed: [factors], [run], [set]"),
    ("factors = 3\n", "factors is no table"),
    ("[factors\n", "is no TOML"),
    ("[factors]\nstrategi = 1\n", "[factors] strategi is unknown; allowed: scenario, strategy"),
    ("[factors]\nscenario = []\n", "[factors] scenario is empty"),
    ("[factors]\nscenario = 3\n", "[factors] scenario cannot be 3; allowed: a text"),
    ("[factors]\nscenario = ['w0', 'w0']\n", "[factors] scenario has 'w0' twice"),
    ("[factors]\nscenario = [['w0']]\n", "[factors] scenario cannot be ['w0']; allowed: a value, or a list of values"),
    (
        "[factors]\nscenario = 'nope'\nstrategy = 'none'\n",
        "[factors] scenario: unknown scenario 'nope'; there are: 221",
    ),
    ("[factors]\nscenario = 'no.sumocfg'\nstrategy = 'none'\n", "[factors] scenario: no such SUMO configuration"),
    ("[factors]\nscenario = 'no_net.sumocfg'\nstrategy = 'none'\n", "no such net file: nowhere.net.xml"),
    ("[factors]\nscenario = 'w0'\nstrategy = 'nope'\n", "[factors] strategy: unknown strategy 'nope'"),
    (
        "[factors]\nscenario = 'w0'\nstrategy = 'staged'\nsensing = 'eyes'\n",
        "[factors] sensing: unknown sensing 'eyes'",
    ),
    ("[factors]\nscenario = 'w0'\nequip = 'nope=1'\n", "[factors] equip: unknown strategy 'nope'"),
    ("[factors]\nscenario = 'w0'\nequip = 'staged=2'\n", "[factors] equip: the share of staged must lie within 0..1"),
    (
        "[factors]\nscenario = ['w0', 'track']\nequip = ['passenger:staged=1', 'spaceship:staged=1']\n",
        "[factors] equip: equipment of 'spaceship', which is no vehicle class and no vehicle type",
    ),
    ("[factors]\nscenario = 'w0'\nequip = 'staged=1'\npenetration = 1\n", "[factors] penetration: needs strategy"),
    (
        "[factors]\nscenario = 'w0'\nstrategy = 'none'\npenetration = 2\n",
        "penetration cannot be 2; allowed: a number within 0 .. 1",
    ),
    ("[factors]\nscenario = 'w0'\nstrategy = 'none'\npenetration = true\n", "penetration cannot be True"),
    ("[factors]\nscenario = 'w0'\nstrategy = 'none'\npenetration = [0.5, 0.50]\n", "has 0.5 twice"),
    ("[factors]\nscenario = 'w0'\nstrategy = 'none'\ndemand = 0\n", "demand cannot be 0; allowed: a number above 0"),
    ("[factors]\nscenario = 'w0'\nstrategy = 'none'\ndemand = nan\n", "demand cannot be nan"),
    ("[factors]\nscenario = 'w0'\nstrategy = 'none'\ndemand = inf\n", "demand cannot be inf"),
    (f"[factors]\nscenario = 'w0'\nstrategy = 'none'\ndemand = 1{'0' * 400}\n", "demand cannot be 1000"),
    (
        f"[factors]\nscenario = 'w0'\nstrategy = 'none'\n[run]\nduration_s = 1{'0' * 400}\n",
        "[run] duration_s cannot be 1000",
    ),
    ("[factors]\nscenario = 'track'\nstrategy = 'none'\ndemand = 2\n", "[factors] demand: track has no flows"),
    (
        "[factors]\nscenario = 'highway'\nstrategy = 'none'\nebike_share = 0.5\n",
        "[factors] ebike_share: highway has no share",
    ),
    (
        "[factors]\nscenario = 'w0'\nstrategy = 'none'\nweather = 'snow'\n",
        "[factors] weather: weather must be one of dry, wet",
    ),
    ("[factors]\nscenario = 'w0'\nstrategy = 'none'\nweather = 'dry'\nmu = 0.5\n", "[factors] mu: excludes weather"),
    ("[factors]\nscenario = 'w0'\nstrategy = 'none'\nmu = 7\n", "[factors] mu: friction of w0 must be within"),
    (
        "[factors]\nscenario = 'w0'\nstrategy = 'none'\ndrivers = 'nope'\n",
        "[factors] drivers: unknown driver profile 'nope'",
    ),
    (
        "[factors]\nscenario = 'w0'\nstrategy = 'none'\nseed = -1\n",
        "[factors] seed cannot be -1; allowed: whole numbers",
    ),
    ("[factors]\nscenario = 'w0'\nstrategy = 'none'\nseed = 1.5\n", "[factors] seed cannot be 1.5"),
    ("[factors]\nscenario = 'w0'\nstrategy = 'none'\nseed = '5..1'\n", "[factors] seed cannot be '5..1'"),
    ("[factors]\nscenario = 'w0'\nstrategy = 'none'\nseed = 'a..b'\n", "[factors] seed cannot be 'a..b'"),
    ("[factors]\nscenario = 'w0'\nstrategy = 'none'\nseed = '0..1000000'\n", "'1..20', a million at most"),
    (
        "[factors]\nscenario = 'w0'\nstrategy = 'none'\n[run]\nduration = 5\n",
        "[run] duration is unknown; allowed: duration_s",
    ),
    ("[factors]\nscenario = 'w0'\nstrategy = 'none'\n[run]\nduration_s = '5'\n", "[run] duration_s cannot be '5'"),
    ("[factors]\nscenario = 'w0'\nstrategy = 'none'\n[run]\nlimit_s = 0\n", "[run] limit_s cannot be 0"),
    (
        "[factors]\nscenario = 'w0'\nstrategy = 'none'\n[run]\nblockage_s = 91\n",
        "[run] blockage_s 91 is too long for w0",
    ),
    (
        "[factors]\nscenario = 'w0'\nstrategy = 'none'\n[run]\nverdicts = 'some'\n",
        "[run] verdicts must be all, none or",
    ),
    ("[factors]\nscenario = 'w0'\nstrategy = 'none'\n[set]\nstaged = 1\n", "[set] staged is no system's table"),
    ("[factors]\nscenario = 'w0'\nstrategy = 'none'\n[set.staged]\nbrake_ttc = 1\n", "[set.staged] is of no system"),
    (
        "[factors]\nscenario = 'w0'\nstrategy = 'staged'\n[set.staged]\nnope = 1\n",
        "[set.staged] nope: Staged has no parameter",
    ),
    (
        "[factors]\nscenario = 'w0'\nstrategy = 'staged'\n[set.staged]\nbrake_ttc = [1, 99]\n",
        "[set.staged] brake_ttc: ",
    ),
]


@pytest.mark.parametrize(("text", "reason"), WRONG, ids=[reason[:40] for _, reason in WRONG])
@pytest.mark.parametrize("name", ["campaign", "plan"])
def test_bad_input_is_one_line_and_touches_nothing(tmp_path, name, text, reason):
    (tmp_path / "SPEC.toml").write_text(text)
    (tmp_path / "no_net.sumocfg").write_text('<configuration><net-file value="nowhere.net.xml"/></configuration>')
    before = sorted(tmp_path.iterdir())
    out = ("--out", "new") if name == "campaign" else ()
    done = command(name, "SPEC.toml", *out, cwd=tmp_path)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert line.startswith("aeb-sumo: ")
    assert "SPEC.toml" in line
    assert reason in line
    assert done.stdout == ""
    assert sorted(tmp_path.iterdir()) == before


def test_a_specification_that_is_not_there_is_one_line(tmp_path):
    with pytest.raises(InputError, match="cannot read the specification"):
        read(Path(tmp_path / "none.toml"))


def test_a_run_does_not_import_what_it_does_not_need():
    code = (
        "import sys, aeb_sumo.campaign.run; from aeb_sumo import strategies; strategies.load('staged');"
        "print(*sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    heavy = {"pandas", "scipy.stats", "scipy.optimize", "scipy.spatial", "matplotlib", "statsmodels", "skfuzzy", "rich"}
    assert "libsumo" in done.stdout.split()
    assert not heavy & set(done.stdout.split())
