"""Builds the networks from their plain-XML sources: `python -m sumo_nets.build [NAME ...]`.

Each folder holds `{name}.netccfg`, the netconvert configuration that makes `{name}.net.xml`, and, where the sources
are computed, a `sources.py`: with an `INTERSECTION`, or with `write(target)`. Needs netconvert (PyPI `eclipse-sumo`,
extras `nets` and `dev`); the built nets are committed, so running the platform does not.
"""

import importlib
import re
import shutil
import subprocess
import sys
from pathlib import Path

import sumo_nets
from sumo_nets import plain

__all__ = ["build", "convert"]


def build(name: str, target: Path) -> Path:
    """Build network `name` in the folder `target` from the sources of its own folder.

    Returns:
        The built net, as `convert` does, with what it raises.
    """
    source = sumo_nets.folder(name)
    if target != source:
        for pattern in ("*.netccfg", "*.nod.xml", "*.edg.xml", "*.con.xml", "*.tll.xml"):
            for path in source.glob(pattern):
                shutil.copy(path, target)
    if (source / "sources.py").exists():
        sources = importlib.import_module(f"sumo_nets.{name}.sources")
        if hasattr(sources, "INTERSECTION"):
            plain.write(sources.INTERSECTION, target, name)
        else:
            sources.write(target)
    return convert(target, name)


def convert(folder: Path, name: str) -> Path:
    """Run netconvert on `{name}.netccfg` in a folder.

    Returns:
        The built net. Its header comment (date, command line) is left out, so that equal sources give equal files.

    Raises:
        FileNotFoundError: netconvert is not installed.
        subprocess.CalledProcessError: netconvert refused the sources.
    """
    netconvert = shutil.which("netconvert") or shutil.which("netconvert", path=str(Path(sys.executable).parent))
    if netconvert is None:
        raise FileNotFoundError("netconvert is not installed: pip install 'aeb-sumo[nets]'")
    subprocess.run(  # noqa: S603 - our own configuration file
        [netconvert, "-c", f"{name}.netccfg"], cwd=folder, check=True, capture_output=True, text=True
    )
    net = folder / f"{name}.net.xml"
    net.write_text(re.sub(r"<!--.*?-->\s*", "", net.read_text(encoding="utf-8"), flags=re.S), encoding="utf-8")
    return net


if __name__ == "__main__":
    for each in sys.argv[1:] or sumo_nets.names():
        print(build(each, sumo_nets.folder(each)))
