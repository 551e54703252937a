"""Random streams: one per purpose, vehicle and encounter, so that no draw moves another."""

from hashlib import blake2b

import numpy as np

__all__ = ["stream"]


def stream(seed: int, *names: str) -> np.random.Generator:
    """A generator that depends on the seed and the names alone, for example `stream(1, "glance", "car.7")`."""
    digest = blake2b("\0".join((str(seed), *names)).encode(), digest_size=16).digest()
    return np.random.Generator(np.random.Philox(key=int.from_bytes(digest, "little")))
