"""Random streams: one per purpose, vehicle and encounter, so that no draw moves another."""

from hashlib import blake2b

import numpy as np

__all__ = ["number", "stream"]


def stream(seed: int, *names: str) -> np.random.Generator:
    """A generator that depends on the seed and the names alone, for example `stream(1, "glance", "car.7")`."""
    return np.random.Generator(np.random.Philox(key=_digest(16, seed, names)))


def number(seed: int, *names: str) -> int:
    """A number below 2**64 that depends on the seed and the names alone."""
    return _digest(8, seed, names)


def _digest(size: int, seed: int, names: tuple[str, ...]) -> int:
    text = "\0".join((str(seed), *names)).encode()
    return int.from_bytes(blake2b(text, digest_size=size).digest(), "little")
