import gzip

import pytest

from aeb_sumo.errors import InputError
from aeb_sumo.scenarios import from_sumocfg
from aeb_sumo.world.sumocfg import read


def cfg(tmp_path, body, root="configuration"):
    path = tmp_path / "run.sumocfg"
    path.write_text(f"<{root}>{body}</{root}>")
    return path


def test_options_in_sections_and_in_both_spellings(tmp_path):
    config = read(
        cfg(
            tmp_path,
            '<time><begin value="1:00:00"/><end v="4000"/></time><n value="nowhere.net.xml"/><seed>3</seed>',
            "sumoConfiguration",
        )
    )
    assert config.options == {"begin": "1:00:00", "end": "4000", "net-file": "nowhere.net.xml", "seed": "3"}


def test_its_own_step_and_span_are_respected(tmp_path):
    scenario = from_sumocfg(cfg(tmp_path, '<time><end value="50"/><step-length value="0.2"/></time>'))
    assert (scenario.step_length, scenario.duration, scenario.seed) == (None, None, None)
    assert from_sumocfg(cfg(tmp_path, '<time><end value="-1"/></time>')).step_length == 0.1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<configuration>", "not well-formed"),
        ("<net/>", "root is <net>"),
        ('<configuration><a value="x.sumocfg,cut.xml"/></configuration>', "cut.xml is not well-formed"),
        ('<configuration><a value="cut.xml.gz"/></configuration>', "cut.xml.gz is not well-formed"),
    ],
)
def test_broken(tmp_path, text, message):
    path = tmp_path / "x.sumocfg"
    path.write_text(text)
    (tmp_path / "cut.xml").write_text("<additional><poi")
    (tmp_path / "cut.xml.gz").write_bytes(gzip.compress(b"<additional/>")[:-9])
    with pytest.raises(InputError, match=message):
        from_sumocfg(path)


def test_missing(tmp_path):
    with pytest.raises(InputError, match="no such SUMO configuration"):
        from_sumocfg(tmp_path / "x.sumocfg")
