"""SUMO networks, one folder each: plain-XML sources, how they are built, the built net, and the traffic on it."""

from importlib.resources import files
from pathlib import Path

__all__ = ["folder", "names"]

_ROOT = Path(str(files(__name__)))


def names() -> tuple[str, ...]:
    """Names of the networks, sorted."""
    return tuple(sorted(p.parent.name for p in _ROOT.glob("*/*.netccfg")))


def folder(name: str) -> Path:
    """The folder of network `name`: `{name}.net.xml`, `{name}.rou.xml` and the sources.

    Raises:
        KeyError: no such network.
    """
    if name not in names():
        raise KeyError(f"no network {name!r}; there are {', '.join(names())}")
    return _ROOT / name
