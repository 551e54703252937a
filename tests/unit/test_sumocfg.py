import pytest

from aeb_sumo.errors import InputError
from aeb_sumo.scenarios import from_sumocfg
from aeb_sumo.world.sumocfg import read


def cfg(tmp_path, body, root="configuration"):
    path = tmp_path / "run.sumocfg"
    path.write_text(f"<{root}>{body}</{root}>")
    return path


def test_options_in_sections_and_in_both_spellings(tmp_path):
    config = read(cfg(tmp_path, '<time><begin value="1:00:00"/><end v="4000"/></time>', "sumoConfiguration"))
    assert config.number("begin") == 3600
    assert config.number("end") == 4000
    assert config.number("seed") is None


def test_its_own_step_and_span_are_respected(tmp_path):
    scenario = from_sumocfg(cfg(tmp_path, '<time><end value="50"/><step-length value="0.2"/></time>'))
    assert (scenario.step_length, scenario.end, scenario.duration, scenario.seed) == (None, 50, None, None)
    scenario = from_sumocfg(cfg(tmp_path, '<time><end value="-1"/></time>'))
    assert (scenario.step_length, scenario.end) == (0.1, None)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<configuration>", "not well-formed"),
        ("<net/>", "root is <net>"),
        ('<configuration><end value="noon"/></configuration>', "end is 'noon'"),
    ],
)
def test_broken(tmp_path, text, message):
    path = tmp_path / "x.sumocfg"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        from_sumocfg(path)


def test_missing(tmp_path):
    with pytest.raises(InputError, match="no such SUMO configuration"):
        from_sumocfg(tmp_path / "x.sumocfg")
