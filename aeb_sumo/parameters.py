"""Parameters as dataclass fields: their ranges, and setting them by name from text or a file."""

import tomllib
from collections.abc import Mapping
from dataclasses import field, fields, is_dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from aeb_sumo.errors import InputError

__all__ = ["changed", "check", "differences", "parse", "read_file", "within"]

P = TypeVar("P")

_HUGE = 10**300  # whole numbers beyond are no floats


def within(default: float, low: float, high: float) -> Any:
    """A dataclass field with a default and the range that `check` allows, ends included."""
    return field(default=default, metadata={"range": (low, high)})


def check(params: Any, *, positive: bool = False) -> None:
    """Check the numbers among the fields of a dataclass: within their range; without one, finite and not negative.

    Args:
        params: the dataclass.
        positive: without a range, 0 is not allowed either.

    Raises:
        InputError: one is not; the message names field, value and allowed range.
    """
    for item in fields(params):
        value = getattr(params, item.name)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            continue
        low, high = item.metadata.get("range", (np.finfo(float).tiny if positive else 0.0, np.inf))
        if np.isnan(value) or not low <= value <= high or (np.isinf(value) and "range" not in item.metadata):
            least = "above 0" if 0 < low < 1e-300 else f"{low:g} or more"
            allowed = f"within {low:g} .. {high:g}" if np.isfinite(high) else f"a number, {least}"
            raise InputError(f"{type(params).__name__}.{item.name} must be {allowed}, not {value:g}")


def changed(params: P, values: Mapping[str, Any]) -> P:
    """A copy of a dataclass with some fields changed; `brake.lag` or a nested mapping reaches into a field.

    Raises:
        InputError: there is no such field, or its value is of the wrong type or out of range.
    """
    known = {item.name: getattr(params, item.name) for item in fields(params)}  # type: ignore[arg-type]
    new: dict[str, Any] = {}
    for path, value in values.items():
        name, _, rest = path.partition(".")
        if name not in known:
            raise InputError(f"{type(params).__name__} has no parameter {name!r}; there are: {', '.join(known)}")
        if rest:
            value = {rest: value}  # noqa: PLW2901
        before = new.get(name, known[name])
        new[name] = _typed(type(params).__name__ + "." + name, before, value)
    return replace(params, **new)  # type: ignore[type-var]


def differences(params: Any) -> str:
    """Fields that differ from the defaults of their class, as `name=value` with spaces between."""
    return " ".join(_between(type(params)(), params, ""))


def _between(usual: Any, params: Any, prefix: str) -> list[str]:
    parts: list[str] = []
    for item in fields(params):
        old, new = getattr(usual, item.name), getattr(params, item.name)
        if new != old and is_dataclass(new) and type(new) is type(old):
            parts += _between(old, new, f"{prefix}{item.name}.")
        elif new != old:
            parts.append(f"{prefix}{item.name}={new}")
    return parts


def _typed(name: str, before: Any, value: Any) -> Any:
    """`value` as the type of the present value."""
    if is_dataclass(before) and isinstance(value, Mapping):
        return changed(before, value)
    if isinstance(before, bool):
        if isinstance(value, bool):
            return value
        raise InputError(f"{name} must be true or false, not {value!r}")
    if isinstance(before, int) and isinstance(value, int) and not isinstance(value, bool):
        return value
    if isinstance(before, float) and isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(np.clip(value, -_HUGE, _HUGE)) if isinstance(value, int) else value
    if isinstance(before, str) and isinstance(value, str):
        return value
    kind = {int: "a whole number", float: "a number", str: "a text"}.get(type(before), "set in Python, not here")
    raise InputError(f"{name} must be {kind}, not {value!r}")


def parse(assignments: tuple[str, ...]) -> dict[str, Any]:
    """Parameters from texts such as `comfort_decel=6` or `brake.lag=0.1`, values as in TOML.

    Raises:
        InputError: a text is no assignment.
    """
    result: dict[str, Any] = {}
    for text in assignments:
        name, equals, value = (part.strip() for part in text.partition("="))
        try:
            result[name] = tomllib.loads(f"x = {value}")["x"]
        except tomllib.TOMLDecodeError:
            result[name] = value
        if not name or not equals or value == "":
            raise InputError(f"cannot read the parameter {text!r}; write NAME=VALUE, for example brake.lag=0.1")
    return result


def read_file(path: Path, what: str = "parameter file") -> dict[str, Any]:
    """Parameters from a TOML file.

    Args:
        path: the file.
        what: it is, for the messages.

    Raises:
        InputError: the file cannot be read or is no TOML.
    """
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"cannot read the {what} {path}: {error.strerror}") from None
    except ValueError as error:  # no UTF-8, no TOML, or a number with thousands of digits
        raise InputError(f"the {what} {path} is no TOML: {error}") from None
