"""Structs of arrays: dataclasses whose fields all share their first axis, one row per vehicle."""

from dataclasses import fields, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

__all__ = ["Bools", "Floats", "Ints", "find", "fitted", "joined", "put", "take"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Ints = NDArray[np.int64]

S = TypeVar("S")


def take(struct: S, rows: Ints | Bools) -> S:
    """A copy of some rows."""
    return replace(struct, **{f.name: getattr(struct, f.name)[rows] for f in fields(struct)})  # type: ignore[type-var, arg-type]


def joined(one: S, two: S) -> S:
    """The rows of one, then those of the other."""
    return replace(one, **{f.name: np.concatenate([getattr(one, f.name), getattr(two, f.name)]) for f in fields(one)})  # type: ignore[type-var, arg-type]


def put(struct: S, rows: Ints | Bools, values: S) -> None:
    """Write `values` into `rows` of `struct`, in place."""
    for f in fields(struct):  # type: ignore[arg-type]
        getattr(struct, f.name)[rows] = getattr(values, f.name)


def find(keys: Ints, among: Ints) -> tuple[Ints, Bools]:
    """Where keys (n,) stand among others, all of which differ, in any order.

    Returns:
        (n,) rows of `among`, and (n,) whether the key is there; where it is not, the row means nothing.
    """
    if not len(among):
        return np.zeros(len(keys), np.int64), np.zeros(len(keys), np.bool_)
    order = np.argsort(among)
    at = order[np.minimum(np.searchsorted(among, keys, sorter=order), len(order) - 1)]
    return at, among[at] == keys


def fitted(array: NDArray[Any], size: int) -> NDArray[Any]:
    """`array` when it has `size` rows or more, else a copy with zeros (False) behind."""
    if len(array) >= size:
        return array
    return np.concatenate([array, np.zeros((size - len(array), *array.shape[1:]), array.dtype)])
