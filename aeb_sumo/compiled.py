"""Kernels: loops over rows that Numba compiles once per machine and keeps beside the source.

In most steps only a few vehicles have anything to decide, so that array operations cost what calling them costs. What
runs in every step is therefore one loop per part of the flow, written as the formulas are.

Rules, which tests/contract/test_kernels.py holds them to:

* A kernel calls only kernels of its own file: Numba's cache looks at the file of the outer one alone, and would go on
  with an old inner one.
* Kernels take arrays and numbers, no objects. They calculate with + - * / and `sqrt`, which give the same bits here as
  in NumPy; sines, powers and exponentials stay with NumPy, whose last digit differs from the C library's.
"""

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

__all__ = ["kernel"]

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile a function at its first call; divisions by zero give `inf` and nan, as in NumPy."""
    return cast("F", njit(cache=True, error_model="numpy")(function))
