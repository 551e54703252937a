"""Kernels over arrays of any shapes."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from aeb_sumo.soa import Floats

__all__ = ["over", "together"]


def together(*values: ArrayLike) -> tuple[Floats, ...]:
    """As arrays of one shape, which they mostly have."""
    arrays = tuple(np.asarray(q, float) for q in values)
    return arrays if len({q.shape for q in arrays}) == 1 else np.broadcast_arrays(*arrays)


def over(kernel: Callable[..., Floats], *values: ArrayLike) -> Floats:
    """What a kernel from (n,) arrays to one gives for values that broadcast, in their shape."""
    arrays = together(*values)
    return kernel(*[q.ravel() for q in arrays]).reshape(arrays[0].shape)
