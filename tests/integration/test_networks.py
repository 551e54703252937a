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
    with pytest.raises(KeyError, match="no network 'nowhere'; there are highway, left_turn, track, w0"):
        sumo_nets.folder("nowhere")


def test_w0_has_the_lateral_offset_of_table_1():
    """a = 4.8 m between the paths of the left-turning car and the oncoming e-bike (Yan et al. 2025, Table 1, W0)."""
    from xml.etree import ElementTree

    root = ElementTree.parse(sumo_nets.folder("w0") / "w0.net.xml").getroot()
    shapes = {lane.get("id"): lane.get("shape") for lane in root.iter("lane")}
    car, bike = (float(shapes[lane].split()[0].split(",")[0]) for lane in ("si_1", "so_0"))
    assert car - bike == pytest.approx(4.8)
