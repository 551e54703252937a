"""What a .sumocfg says, before SUMO reads it."""

import gzip
import zlib
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree
from xml.parsers import expat

from aeb_sumo.errors import InputError

__all__ = ["SumoConfig", "read"]

_SYNONYMS = {
    "n": "net-file", "net": "net-file", "r": "route-files", "routes": "route-files", "a": "additional-files",
    "additional": "additional-files",
}  # fmt: skip
"""Other names that SUMO takes for the options that matter here."""


@dataclass(frozen=True)
class SumoConfig:
    """A user's own configuration.

    Attributes:
        path: the file, absolute.
        options: SUMO option -> value, as written there.
    """

    path: Path
    options: dict[str, str]


def read(path: str | Path) -> SumoConfig:
    """Read a .sumocfg.

    Raises:
        InputError: the file is missing, is not a SUMO configuration or asks for a mesoscopic simulation; or a net,
            route or additional file that it names is not well-formed.
    """
    path = Path(path).absolute()  # a link stays one: SUMO looks for the other files beside it
    if not path.is_file():
        raise InputError(f"no such SUMO configuration: {path}")
    try:
        root = ElementTree.parse(path).getroot()  # noqa: S314 - the user's own file, which SUMO reads next
    except ElementTree.ParseError as error:
        raise InputError(f"{path} is not well-formed XML: {error}") from None
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from None
    # The root is <configuration> or <sumoConfiguration>; options stand in sections or directly below it.
    if not root.tag.lower().endswith("configuration"):
        raise InputError(f"{path} is not a SUMO configuration: its root is <{root.tag}>")
    options = {}
    for element in root.iter():
        value = element.get("value", element.get("v", element.text if not len(element) else None))
        if value is not None and value.strip():
            options[_SYNONYMS.get(element.tag, element.tag)] = value.strip()
    # Refused before SUMO starts: after a mesoscopic run, SUMO 1.28 misjudges bicycles in the same process.
    if options.get("mesosim", "false").lower() in {"true", "1", "yes", "on", "t"}:
        raise InputError(f"{path}: mesosim is true; a mesoscopic simulation has no gaps for an AEB to see")
    for option in ("net-file", "route-files", "additional-files"):
        for name in filter(None, (part.strip() for part in options.get(option, "").split(","))):
            _check_well_formed(path.parent / name)
    return SumoConfig(path, options)


def _check_well_formed(path: Path) -> None:
    """SUMO 1.28 ends the whole process with a segmentation fault on a file that stops inside a tag.

    A file that is not there is left to SUMO, which says so.
    """
    if not path.is_file():
        return
    try:
        with path.open("rb") as file:
            packed = file.read(2) == b"\x1f\x8b"
        with gzip.open(path) if packed else path.open("rb") as file:
            expat.ParserCreate().ParseFile(file)
    except (expat.ExpatError, OSError, EOFError, zlib.error) as error:
        raise InputError(f"{path} is not well-formed XML: {error}") from None
