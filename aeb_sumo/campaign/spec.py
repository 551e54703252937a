"""What a campaign is: a TOML file with the factors that are varied, and what all runs have in common."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np

from aeb_sumo.errors import InputError
from aeb_sumo.parameters import read_file
from aeb_sumo.verdicts.choice import Choice

__all__ = ["Common", "Spec", "read"]

SEEDS = (0, 2**31 - 1)
_MOST_SEEDS = 1_000_000

Value = str | int | float | bool


@dataclass(frozen=True, kw_only=True)
class Common:
    """`[run]`: what all runs have in common.

    Attributes:
        duration_s: simulated time; None for the scenario's.
        step_length_s: None for the scenario's.
        blockage_s: how long crashed vehicles stand; None as in `aeb_sumo.simulate.run`.
        interval_s: of the rows of table `traffic`.
        verdicts: which interventions are judged.
        limit_s: wall time after which a run is killed; six hours, our assumption. It is no part of a run's id.
    """

    duration_s: float | None = None
    step_length_s: float | None = None
    blockage_s: float | None = None
    interval_s: float = 60.0
    verdicts: str = "none"
    limit_s: float = 21600.0


@dataclass(frozen=True, kw_only=True)
class Spec:
    """A campaign as it was written; what the names in it stand for is not looked up yet.

    Attributes:
        path: of the file.
        factors: name -> values, in the order of the file.
        parameters: `[set.SYSTEM]`: system -> parameter -> values.
        common: `[run]`.
    """

    path: Path
    factors: Mapping[str, tuple[Any, ...]]
    parameters: Mapping[str, Mapping[str, tuple[Any, ...]]] = field(default_factory=dict)
    common: Common = field(default_factory=Common)


def _text(value: Any) -> str:
    return "" if isinstance(value, str) and value.strip() else "a text"


def _number(low: float, high: float, *, open_below: bool = False) -> Callable[[Any], str]:
    """A check that gives what is allowed, empty for a number within its range."""
    allowed = f"a number within {low:g} .. {high:g}" if np.isfinite(high) else f"a number, {low:g} or more"
    allowed = "a number above 0" if open_below else allowed

    def check(value: Any) -> str:
        if isinstance(value, bool) or not isinstance(value, int | float):
            return allowed
        inside = (low < value if open_below else low <= value) and value <= high and abs(value) < np.inf
        return "" if inside else allowed

    return check


def _seed(value: Any) -> str:
    whole = isinstance(value, int) and not isinstance(value, bool) and SEEDS[0] <= value <= SEEDS[1]
    return "" if whole else "whole numbers within 0 .. 2147483647, or FIRST..LAST such as '1..20'"


FACTORS: dict[str, Callable[[Any], str]] = {
    "scenario": _text,
    "strategy": _text,
    "sensing": _text,
    "penetration": _number(0, 1),
    "equip": _text,
    "demand": _number(0, np.inf, open_below=True),
    "ebike_share": _number(0, 1),
    "weather": _text,
    "mu": _number(0, np.inf, open_below=True),
    "drivers": _text,
    "seed": _seed,
}
"""Factor -> what a value must be, in words; empty if it is. The names are those of the options of `aeb-sumo run`."""

_COMMON: dict[str, Callable[[Any], str]] = {
    "duration_s": _number(0, np.inf, open_below=True),
    "step_length_s": _number(0, np.inf, open_below=True),
    "blockage_s": _number(0, np.inf),
    "interval_s": _number(0, np.inf, open_below=True),
    "verdicts": _text,
    "limit_s": _number(0, np.inf, open_below=True),
}
_TABLES = ("factors", "run", "set")


def read(path: Path) -> Spec:
    """Read a SPEC.toml.

    Raises:
        InputError: it cannot be read, or has an unknown table or key, an empty factor, a value of the wrong type or out
            of range, or one twice; the message names file, key and what is allowed.
    """
    data = read_file(path, "specification")
    for name, table in data.items():
        if name not in _TABLES:
            raise _refusal(path, name, "is unknown", "[" + "], [".join(_TABLES) + "]")
        if not isinstance(table, Mapping):
            raise _refusal(path, name, "is no table", f"[{name}]")
    factors = {key: _values(path, key, value) for key, value in data.get("factors", {}).items()}
    if "scenario" not in factors or not {"strategy", "equip"} & factors.keys():
        missing = "strategy or equip" if "scenario" in factors else "scenario"
        raise InputError(f"{path}: [factors] needs {missing}; allowed: {', '.join(FACTORS)}")
    if {"weather", "mu"} <= factors.keys():
        raise InputError(f"{path}: [factors] mu: excludes weather, which stands for a mu; allowed: one of them")
    for key in ("sensing", "penetration"):
        if key in factors and "strategy" not in factors:
            raise InputError(f"{path}: [factors] {key}: needs strategy; equip says its shares and sensors itself")
    parameters, common = _parameters(path, data.get("set", {})), _common(path, data.get("run", {}))
    return Spec(path=path, factors=factors, parameters=parameters, common=common)


def _values(path: Path, key: str, value: Any) -> tuple[Any, ...]:
    """The values of a factor; one that stands alone is a list of one."""
    if key not in FACTORS:
        raise _refusal(path, f"[factors] {key}", "is unknown", ", ".join(FACTORS))
    values = _seeds(path, value) if key == "seed" and isinstance(value, str) else _list(path, f"[factors] {key}", value)
    for each in values:
        if allowed := FACTORS[key](each):
            raise _refusal(path, f"[factors] {key}", f"cannot be {each!r}", allowed)
    # 1 and 1.0 are the same, but would not be in an id.
    return values if key == "seed" else tuple(v if isinstance(v, str) else float(v) for v in values)


def _list(path: Path, key: str, value: Any) -> tuple[Any, ...]:
    values = tuple(value) if isinstance(value, list) else (value,)
    if not values:
        raise _refusal(path, key, "is empty", "one value or more")
    seen: list[Any] = []
    for each in values:
        if isinstance(each, list | Mapping):
            raise _refusal(path, key, f"cannot be {each!r}", "a value, or a list of values")
        if each in seen:
            raise _refusal(path, key, f"has {each!r} twice", "different values")
        seen.append(each)
    return values


def _seeds(path: Path, text: str) -> tuple[int, ...]:
    """`1..20`."""
    first, dots, last = (part.strip() for part in text.partition(".."))
    numbers = first.isdecimal() and last.isdecimal() and max(len(first), len(last)) < 11
    if not dots or not numbers or not 0 <= int(last) - int(first) < _MOST_SEEDS:
        raise _refusal(path, "[factors] seed", f"cannot be {text!r}", _seed(None))
    return tuple(range(int(first), int(last) + 1))


def _parameters(path: Path, table: Mapping[str, Any]) -> dict[str, dict[str, tuple[Any, ...]]]:
    """`[set.SYSTEM]`: what they are called is for the system to know."""
    result: dict[str, dict[str, tuple[Any, ...]]] = {}
    for system, values in table.items():
        if not isinstance(values, Mapping):
            raise _refusal(path, f"[set] {system}", "is no system's table", "[set.SYSTEM] with NAME = VALUE")
        result[system] = {name: _list(path, f"[set.{system}] {name}", v) for name, v in _flat(values).items()}
    return result


def _flat(values: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """`{"brake": {"lag": 0.1}}` as `{"brake.lag": 0.1}`: TOML reads `brake.lag = 0.1` so."""
    flat: dict[str, Any] = {}
    for name, value in values.items():
        flat |= _flat(value, f"{prefix}{name}.") if isinstance(value, Mapping) else {prefix + name: value}
    return flat


def _common(path: Path, table: Mapping[str, Any]) -> Common:
    for key, value in table.items():
        if key not in _COMMON:
            raise _refusal(path, f"[run] {key}", "is unknown", ", ".join(f.name for f in fields(Common)))
        if allowed := _COMMON[key](value):
            raise _refusal(path, f"[run] {key}", f"cannot be {value!r}", allowed)
    try:
        Choice.parse(table.get("verdicts", "none"))
    except InputError as error:
        raise InputError(f"{path}: [run] {error}") from None
    values: dict[str, Any] = {key: v if isinstance(v, str) else float(v) for key, v in table.items()}
    return Common(**values)


def _refusal(path: Path, what: str, why: str, allowed: str) -> InputError:
    return InputError(f"{path}: {what} {why}; allowed: {allowed}")
