"""Driver profiles: named sets of parameters of everything that drivers and riders do wrong, as TOML files.

The packaged ones lie in `aeb_sumo/drivers/profiles`. Users copy and change them: `aeb-sumo drivers NAME > mine.toml`.
A section that is absent is something that nobody does; a field that is absent has its default.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from aeb_sumo.drivers.encounters import FailureToYield, Riders, Warned
from aeb_sumo.drivers.lapses import Glances, HardBraking, Robots
from aeb_sumo.drivers.reactions import MODELS, Looming, Reaction, trucks
from aeb_sumo.errors import InputError
from aeb_sumo.parameters import changed, read_file

__all__ = ["ROBOTS", "Profile", "load", "names", "text"]

_FOLDER = Path(str(files("aeb_sumo.drivers"))) / "profiles"


@dataclass(frozen=True, kw_only=True)
class Profile:
    """What the drivers and riders of a scenario do wrong; None for an error that they do not make.

    Attributes:
        name: for the tables.
        glances, hard_braking: lapses of drivers.
        cars, trucks: how drivers react to a vehicle ahead that they are late for, or that takes them by surprise; None:
            as SUMO's do, at once.
        failure_to_yield, riders: errors at junctions.
        warned: what drivers do when they are warned; None: nothing.
        robots: nobody drives; for the proving ground.
    """

    name: str = "sumo"
    glances: Glances | None = None
    hard_braking: HardBraking | None = None
    cars: Reaction | None = None
    trucks: Reaction | None = None
    failure_to_yield: FailureToYield | None = None
    riders: Riders | None = None
    warned: Warned | None = None
    robots: Robots | None = None


ROBOTS = Profile(name="robots", robots=Robots())
"""Nobody drives: the proving ground."""

_SECTIONS: dict[str, Any] = {
    "glances": Glances, "hard_braking": HardBraking, "cars": Looming, "trucks": trucks,
    "failure_to_yield": FailureToYield, "riders": Riders, "warned": Warned,
}  # fmt: skip


def names() -> tuple[str, ...]:
    """Names of the packaged profiles, sorted."""
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.toml")))


def text(name: str) -> str:
    """A packaged profile as it is written, comments and all.

    Raises:
        InputError: there is none of that name.
    """
    if name not in names():
        raise InputError(f"unknown driver profile {name!r}; there are: {', '.join(names())}, or a file NAME.toml")
    return (_FOLDER / f"{name}.toml").read_text(encoding="utf-8")


def load(name: str) -> Profile:
    """A profile by name, or from a file whose name ends with `.toml`.

    Raises:
        InputError: there is none, or it has an unknown section or field or a value out of range; the message names the
            file and what is allowed.
    """
    if not name.endswith(".toml"):
        text(name)
        return _profile(name, read_file(_FOLDER / f"{name}.toml"))
    try:
        return _profile(name, read_file(Path(name)))
    except InputError as error:
        raise InputError(str(error) if name in str(error) else f"{name}: {error}") from None


def _profile(name: str, data: Mapping[str, Any]) -> Profile:
    """A profile from the content of its file."""
    if unknown := set(data) - set(_SECTIONS):
        raise InputError(f"{name}: unknown section {sorted(unknown)[0]!r}; there are: {', '.join(_SECTIONS)}")
    parts: dict[str, Any] = {}
    for section, values in data.items():
        if not isinstance(values, Mapping):
            raise InputError(f"{name}: {section} must be a section, [{section}], not a value")
        usual, values = _SECTIONS[section](), dict(values)  # noqa: PLW2901
        if isinstance(usual, Reaction) and (model := values.pop("model", usual.model)) != usual.model:
            if not isinstance(model, str) or model not in MODELS:
                raise InputError(f"{name}: unknown model {model!r} in [{section}]; there are: {', '.join(MODELS)}")
            usual = MODELS[model]()
        parts[section] = changed(usual, values)
    return Profile(name=name, **parts)
