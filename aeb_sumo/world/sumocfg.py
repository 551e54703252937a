"""What a .sumocfg says, before SUMO reads it."""

import gzip
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree
from xml.parsers import expat

from aeb_sumo.errors import InputError

__all__ = ["SumoConfig", "read"]


@dataclass(frozen=True)
class SumoConfig:
    """A user's own configuration.

    Attributes:
        path: the file, absolute.
        options: SUMO option -> value, as written there.
    """

    path: Path
    options: dict[str, str]

    def number(self, option: str) -> float | None:
        """An option's value as a number: seconds, or `H:M:S` and `D:H:M:S`; None when it is not set."""
        text = self.options.get(option)
        if text is None:
            return None
        try:
            seconds = 0.0
            for part, size in zip(reversed(text.split(":")), (1, 60, 3600, 86400), strict=False):
                seconds += float(part) * size
        except ValueError:
            raise InputError(f"{self.path}: {option} is {text!r}, which is not a number or a time") from None
        return seconds


def read(path: str | Path) -> SumoConfig:
    """Read a .sumocfg.

    Raises:
        InputError: the file is missing or is not a SUMO configuration, or a net, route or additional file that it
            names is not well-formed.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"no such SUMO configuration: {path}")
    try:
        root = ElementTree.parse(path).getroot()  # noqa: S314 - the user's own file, which SUMO reads next
    except ElementTree.ParseError as error:
        raise InputError(f"{path} is not well-formed XML: {error}") from None
    # The root is <configuration> or <sumoConfiguration>; options stand in sections or directly below it.
    if not root.tag.lower().endswith("configuration"):
        raise InputError(f"{path} is not a SUMO configuration: its root is <{root.tag}>")
    options = {
        element.tag: value for element in root.iter() if (value := element.get("value", element.get("v"))) is not None
    }
    config = SumoConfig(path.resolve(), options)
    for option in ("net-file", "route-files", "additional-files"):
        for name in filter(None, (part.strip() for part in options.get(option, "").split(","))):
            _check_well_formed(config.path.parent / name)
    return config


def _check_well_formed(path: Path) -> None:
    """SUMO 1.28 ends the whole process with a segmentation fault on a file that stops inside a tag.

    A file that is not there is left to SUMO, which says so.
    """
    if not path.is_file():
        return
    try:
        with gzip.open(path) if path.suffix == ".gz" else path.open("rb") as file:
            expat.ParserCreate().ParseFile(file)
    except (expat.ExpatError, OSError) as error:
        raise InputError(f"{path} is not well-formed XML: {error}") from None
