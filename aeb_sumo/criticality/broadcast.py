"""Kernels over arrays of any shapes."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from aeb_sumo.soa import Floats

__all__ = ["over"]


def over(kernel: Callable[..., Floats], *values: ArrayLike) -> Floats:
    """What a kernel from (n,) arrays to one gives for values that broadcast, in their shape."""
    arrays: Sequence[Floats] = [np.asarray(q, float) for q in values]
    if len({q.shape for q in arrays}) > 1:
        arrays = np.broadcast_arrays(*arrays)
    return kernel(*[q.ravel() for q in arrays]).reshape(arrays[0].shape)
