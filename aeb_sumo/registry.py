"""Finds strategies, scenarios and the like: one file each in its package, or an entry point from outside."""

import importlib
import pkgutil
from functools import cache
from importlib.metadata import entry_points
from typing import Any

from aeb_sumo.errors import InputError

__all__ = ["find", "registered"]


@cache
def registered(package: str, attribute: str) -> dict[str, Any]:
    """All of one kind, by name: every module of `package` that has `attribute`, and every entry point.

    The entry-point group is `aeb_sumo.<last part of the package>`, for example `aeb_sumo.strategies`; an entry point
    names the object itself.

    Args:
        package: dotted name of the package whose modules are searched.
        attribute: name of the module-level object that a module of this kind defines; it has a `name`.
    """
    found = {}
    parent = importlib.import_module(package)
    for info in pkgutil.iter_modules(parent.__path__, package + "."):
        item = getattr(importlib.import_module(info.name), attribute, None)
        if item is not None:
            found[item.name] = item
    for point in entry_points(group="aeb_sumo." + package.rpartition(".")[2]):
        found[point.name] = point.load()
    return dict(sorted(found.items()))


def find(package: str, attribute: str, kind: str, name: str) -> Any:
    """One of a kind by name.

    Raises:
        InputError: there is none of that name; the message lists those that there are.
    """
    items = registered(package, attribute)
    if name not in items:
        raise InputError(f"unknown {kind} {name!r}; there are: {', '.join(items)}")
    return items[name]
