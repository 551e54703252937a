"""Kernels: loops over rows that Numba compiles once per machine and keeps beside the source.

In most steps only a few vehicles have anything to decide, so that array operations cost what calling them costs. What
runs in every step is therefore one loop per part of the flow, written as the formulas are.

Rules, which tests/contract/test_kernels.py holds them to:

* A kernel calls only kernels of its own file, and takes numbers from there or as arguments: Numba's cache looks at the
  file of the outer one alone, and would go on with old ones.
* Kernels take arrays and numbers, no objects. They calculate with + - * / and `sqrt`, which give the same bits here as
  in NumPy; sines, powers and exponentials stay with NumPy, whose last digit differs from the C library's.
"""

from collections.abc import Callable, Iterable
from contextlib import suppress
from importlib import import_module
from typing import Any, TypeVar, cast

from numba import njit
from numba.core import event

__all__ = ["announce", "kernel", "known", "prepare"]

Known = tuple[str, str, tuple[Any, ...]]
"""Module and name of a kernel, and the types of its arguments."""

_kernels: list[Any] = []

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile a function at its first call; divisions by zero give `inf` and nan, as in NumPy."""
    try:
        compiled = njit(cache=True, error_model="numpy")(function)
    except RuntimeError:  # nowhere to keep it: neither beside the source nor in a folder of the user's
        compiled = njit(error_model="numpy")(function)
    _kernels.append(compiled)
    return cast("F", compiled)


def known() -> list[Known]:
    """The kernels that this process has compiled or loaded, to be given `prepare` in another."""
    return [(each.__module__, each.__name__, types) for each in _kernels for types in each.signatures]


def prepare(kernels: Iterable[Known]) -> None:
    """Compile or load kernels before they are called; from `known` of a process of the same program.

    One that cannot be found by its name, as it was made within a function, is left out.
    """
    for module, name, types in kernels:
        with suppress(AttributeError, ImportError):
            getattr(import_module(module), name).compile(types)


def announce(say: Callable[[], None]) -> None:
    """Call `say` once, before the first kernel that this process has to compile."""
    event.register("numba:compile", _Once(say))  # type: ignore[no-untyped-call]


class _Once(event.Listener):
    def __init__(self, say: Callable[[], None]) -> None:
        self._say: Callable[[], None] | None = say

    def on_start(self, _: Any) -> None:
        if self._say is not None:
            self._say()
        self._say = None

    def on_end(self, _: Any) -> None:
        pass
