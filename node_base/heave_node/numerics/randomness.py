"""Seeded random streams: one seed fixes everything, and no stream disturbs another."""

from __future__ import annotations

import zlib

import numpy as np


def random_stream(seed: int, name: str) -> np.random.Generator:
    """Return the generator of the stream `name` (for example "wave_vessel/mru") under the run's `seed`.

    Streams of different names are independent, and adding one leaves the numbers of all others as they were.
    """
    return np.random.default_rng([seed, zlib.crc32(name.encode())])
