"""What works from a checkout works from a wheel."""

import zipfile

from hatchling.builders.wheel import WheelBuilder

import sumo_nets


def test_the_wheel_holds_the_three_packages_and_the_nets(tmp_path):
    from pathlib import Path

    root = Path(__file__).parents[2]
    (wheel,) = WheelBuilder(str(root)).build(directory=str(tmp_path), versions=["standard"])
    names = set(zipfile.ZipFile(wheel).namelist())
    for package in ("aeb_sumo", "analysis", "sumo_nets"):
        assert {f"{package}/__init__.py", f"{package}/py.typed"} <= names
    for net in sumo_nets.names():
        assert f"sumo_nets/{net}/{net}.net.xml" in names
    assert {"sumo_nets/highway/highway.rou.xml", "sumo_nets/w2t/w2t.add.xml"} <= names
    assert {"analysis/report/report.html.j2", "analysis/report/report.css"} <= names
    assert not [n for n in names if n.startswith("tests")]


def test_analysis_needs_no_sumo():
    """Importing it must not import libsumo."""
    import subprocess
    import sys

    code = "import sys, analysis; sys.exit('libsumo' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
