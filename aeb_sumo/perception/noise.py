"""Noise that depends on who, when and what for alone: no draw moves another, whatever order they are made in."""

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from aeb_sumo.soa import Floats, Ints

__all__ = ["Keys", "normals", "uniforms"]

Keys = NDArray[np.uint64]

_TOP_53 = np.uint64(11)


def _mix(x: Keys) -> Keys:
    """SplitMix64 (Steele, Lea, Flood 2014): neighbouring inputs give unrelated outputs."""
    x = x + np.uint64(0x9E3779B97F4A7C15)
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


def uniforms(keys: Keys, counter: Ints, channel: int) -> Floats:
    """One number within (0, 1) per row.

    Args:
        keys: (n,) who.
        counter: (n,) when, >= 0.
        channel: what for.
    """
    with np.errstate(over="ignore"):
        x = _mix(keys ^ _mix(counter.astype(np.uint64) * np.uint64(64) + np.uint64(channel)))
    result: Floats = ((x >> _TOP_53).astype(float) + 0.5) * 2.0**-53
    return result


def normals(keys: Keys, counter: Ints, channel: int) -> Floats:
    """One standard normal number per row; arguments as for `uniforms`."""
    result: Floats = ndtri(uniforms(keys, counter, channel))
    return result
