"""Structs of arrays: dataclasses, without slots, whose fields all share their first axis, one row per vehicle."""

from dataclasses import fields
from functools import cache
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from aeb_sumo.compiled import kernel

__all__ = ["Bools", "Floats", "Ints", "find", "fitted", "joined", "mask", "put", "take"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Ints = NDArray[np.int64]

S = TypeVar("S")


def take(struct: S, rows: Ints | Bools) -> S:
    """A copy of some rows."""
    rows, values = _numbers(rows), vars(struct)
    return _made(struct, {name: values[name][rows] for name in _names(struct)})


def joined(one: S, two: S) -> S:
    """The rows of one, then those of the other."""
    first, second = vars(one), vars(two)
    return _made(one, {name: np.concatenate((first[name], second[name])) for name in _names(one)})


def put(struct: S, rows: Ints | Bools, values: S) -> None:
    """Write `values` into `rows` of `struct`, in place."""
    rows, old, new = _numbers(rows), vars(struct), vars(values)
    for name in _names(struct):
        old[name][rows] = new[name]


def _made(like: S, values: dict[str, NDArray[Any]]) -> S:
    """Another of the same kind; what `dataclass` makes for a frozen one takes longer than the arrays in it."""
    result: S = object.__new__(type(like))
    vars(result).update(values)
    return result


def _names(struct: Any) -> tuple[str, ...]:
    return _names_of(type(struct))  # type: ignore[arg-type]


@cache
def _names_of(kind: Any) -> tuple[str, ...]:
    return tuple(f.name for f in fields(kind))


def _numbers(rows: Ints | Bools) -> NDArray[Any]:
    """Row numbers in place of a mask, which would have to be counted for every array anew."""
    return rows.nonzero()[0] if rows.dtype == np.bool_ else rows


def mask(rows: Ints, size: int) -> Bools:
    """(size,) True in these rows."""
    result = np.zeros(size, np.bool_)
    result[rows] = True
    return result


def find(keys: Ints, among: Ints) -> tuple[Ints, Bools]:
    """Where keys (n,) stand among others, all of which differ, in any order.

    Returns:
        (n,) rows of `among`, and (n,) whether the key is there; where it is not, the row means nothing.
    """
    if not len(among):
        return np.zeros(len(keys), np.int64), np.zeros(len(keys), np.bool_)
    return _find(keys, among)


@kernel
def _find(keys: Ints, among: Ints) -> tuple[Ints, Bools]:
    order = among.argsort()
    rising = among[order]
    at, known = np.empty(len(keys), np.int64), np.empty(len(keys), np.bool_)
    for k in range(len(keys)):
        j = min(int(np.searchsorted(rising, keys[k])), len(order) - 1)
        at[k], known[k] = order[j], rising[j] == keys[k]
    return at, known


def fitted(array: NDArray[Any], size: int) -> NDArray[Any]:
    """`array` when it has `size` rows or more, else a copy with zeros (False) behind."""
    if len(array) >= size:
        return array
    return np.concatenate([array, np.zeros((size - len(array), *array.shape[1:]), array.dtype)])
