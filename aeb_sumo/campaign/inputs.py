"""Content of the files that a scenario reads: what makes two of them the same on any machine and path."""

import hashlib
import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from aeb_sumo.errors import InputError
from aeb_sumo.scenarios import Scenario
from aeb_sumo.world.sumocfg import read

__all__ = ["digest", "files", "of_file", "options_of", "seed_of", "source", "span_of", "switches", "teleport_after"]

_CONFIGURATION = "configuration-file"
_SHORT = {"n": "net-file", "r": "route-files", "a": "additional-files", "c": _CONFIGURATION}
_NEEDED = ("net-file", "route-files", "additional-files")
_WRITTEN = re.compile(r"output|log$")  # options of what SUMO writes, which may lie there from before
# Files that other files name: included ones, and what rerouters and speed signs read.
_NAMED = re.compile(rb"""<(?:include\s+href|(?:rerouter|variableSpeedSign)\b[^>]*?\sfile)\s*=\s*["']([^"']+)["']""")

_SUMO_SEED = 23423
_SUMO_TELEPORT = 300.0  # s


def digest(content: str | bytes) -> str:
    """The first 16 hexadecimal digits of the SHA-256."""
    return hashlib.sha256(content.encode() if isinstance(content, str) else content).hexdigest()[:16]


def of_file(path: Path) -> str:
    """Digest of a file's content.

    Raises:
        InputError: it cannot be read.
    """
    return digest(_content(path))


@cache
def source() -> str:
    """Digest of the program's own source files: its version, to the last letter."""
    package = Path(__file__).parents[1]
    return digest("\n".join(f"{p.relative_to(package).as_posix()} {of_file(p)}" for p in sorted(package.rglob("*.py"))))


def options_of(scenario: Scenario) -> dict[str, str]:
    """SUMO options of a scenario, and those of its configuration that it does not set itself, with absolute paths.

    Raises:
        InputError: the configuration cannot be read.
    """
    own = _own(scenario)
    if _CONFIGURATION not in own:
        return own
    config = read(own[_CONFIGURATION])
    return {name: _absolute(value, config.path.parent) for name, value in config.options.items()} | own


def _own(scenario: Scenario) -> dict[str, str]:
    """SUMO options of a scenario by their long names."""
    own: dict[str, str] = {}
    last = ""
    for word in scenario.sumo_options:
        name = word.lstrip("-")
        if word.startswith("-") and not name[:1].isdigit():  # else a negative number
            name, _, value = name.partition("=")
            last = _SHORT.get(name, name)
            own[last] = value
        else:
            own[last] = word
    return own


def switches(scenario: Scenario) -> dict[str, str]:
    """SUMO options of a scenario that name no file; those in a configuration are told by that file."""
    return {k: v for k, v in sorted(_own(scenario).items()) if not any(Path(part).is_file() for part in _split(v))}


def _absolute(value: str, folder: Path) -> str:
    return ",".join(str(folder / part) if (folder / part).is_file() else part for part in _split(value))


def _split(value: str) -> list[str]:
    return [part.strip() for part in value.split(",")]


def files(scenario: str, options: Mapping[str, str]) -> dict[str, str]:
    """What a scenario reads: option, and number where it names several -> digest of the file.

    Files that other files include are among them. What SUMO writes is not.

    Args:
        scenario: its name, for the messages.
        options: from `options_of`.

    Raises:
        InputError: the net, a route file or an additional file is missing, or one cannot be read.
    """
    found: dict[str, str] = {}
    for option, value in options.items():
        if _WRITTEN.search(option):
            continue
        for number, name in enumerate(_split(value)):
            if name and Path(name).is_file():
                _add(found, f"{option}.{number}" if number else option, Path(name), frozenset())
            elif name and option in _NEEDED:
                raise InputError(f"{scenario}: no such {option.removesuffix('s').replace('-', ' ')}: {name}")
    return found


def _add(found: dict[str, str], key: str, path: Path, within: frozenset[Path]) -> None:
    """A file and those that it names, which lie beside it."""
    content = _content(path)
    found[key] = digest(content)
    for number, name in enumerate(_NAMED.findall(content)):
        named = path.parent / name.decode(errors="replace")
        if named.is_file() and named not in within:
            _add(found, f"{key}/{number}", named, within | {path, named})


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from None


def seed_of(scenario: Scenario, options: Mapping[str, str]) -> int:
    """The seed that a scenario has without being told one."""
    own = options.get("seed", "")
    return scenario.seed if scenario.seed is not None else int(own) if own.isdecimal() else _SUMO_SEED


def span_of(scenario: Scenario, options: Mapping[str, str]) -> float | None:
    """Simulated time that a scenario has without being told one [s]; None until all vehicles have arrived."""
    if scenario.duration is not None:
        return scenario.duration
    span = _seconds(options, "end", -1.0) - _seconds(options, "begin", 0.0)
    return span if span > 0 else None


def teleport_after(options: Mapping[str, str]) -> float:
    """SUMO's time-to-teleport [s], inf for never: no wreck can stand for longer."""
    seconds = _seconds(options, "time-to-teleport", _SUMO_TELEPORT)
    return seconds if seconds > 0 else float("inf")


def _seconds(options: Mapping[str, str], name: str, default: float) -> float:
    """A time among the options; the default also for what SUMO will have to read or refuse itself."""
    try:
        return float(options.get(name, default))
    except ValueError:
        return default
