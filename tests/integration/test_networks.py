"""The committed networks are what their sources make."""

import shutil
import sys
from pathlib import Path

import pytest

import sumo_nets
from sumo_nets.build import build

HAS_NETCONVERT = shutil.which("netconvert") or (Path(sys.executable).parent / "netconvert").exists()


@pytest.mark.skipif(not HAS_NETCONVERT, reason="netconvert is not installed (extra: dev)")
@pytest.mark.parametrize("name", sumo_nets.names())
def test_rebuilding_gives_the_committed_net(name, tmp_path):
    committed = sumo_nets.folder(name) / f"{name}.net.xml"
    assert build(name, tmp_path).read_text() == committed.read_text()


def test_an_unknown_net_is_named():
    with pytest.raises(KeyError, match="no network 'nowhere'; there are b2, crossroads, highway, left_turn, street"):
        sumo_nets.folder("nowhere")
