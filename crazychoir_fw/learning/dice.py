"""Random numbers by counter: what an episode draws depends on its seed and its number, and on nothing else.

So a flight begins alike at any number of flights, whichever of them ends first. The mixer is splitmix64 (Steele, Lea
and Flood, OOPSLA 2014), in vectors.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_FIRST, _SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)


def mixed(numbers: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Return 64 well mixed bits of each number."""
    with np.errstate(over="ignore"):
        z = numbers + _GOLDEN
        z = (z ^ (z >> np.uint64(30))) * _FIRST
        z = (z ^ (z >> np.uint64(27))) * _SECOND
    return z ^ (z >> np.uint64(31))


def episode_keys(seeds: NDArray[np.uint64], episodes: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Return a key per episode.

    Args:
        seeds: Seed of each flight, shape (n,).
        episodes: Number of the episode of each, counted from its seed, shape (n,).
    """
    return mixed(mixed(seeds) ^ episodes)


def uniforms(keys: NDArray[np.uint64], columns: int, stream: int = 0) -> NDArray[np.float64]:
    """Return numbers in [0, 1), shape (n, columns), of keys of shape (n,); each stream has numbers of its own."""
    counters = np.arange(1 + stream * 256, 1 + stream * 256 + columns, dtype=np.uint64)
    return (mixed(keys[:, None] ^ mixed(counters)[None, :]) >> np.uint64(11)) * 2.0**-53
