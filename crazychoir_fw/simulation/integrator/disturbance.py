"""Forces that nobody commanded."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError


class RandomForce:
    """A seeded random force (N, world) on each drone: Gaussian, correlated over a time, constant within a step.

    The sequence of a drone depends on the seed and its index alone, not on how many others there are.
    """

    def __init__(self, sigma: float, time_constant: float = 1.0, seed: int = 0) -> None:
        """Choose the force.

        Args:
            sigma: Standard deviation per axis (N).
            time_constant: Correlation time (s); 0 draws each step anew.
            seed: Seed.

        Raises:
            RangeError: If a number is outside its range.
        """
        if not (math.isfinite(sigma) and sigma >= 0.0):
            raise RangeError(f"sigma is {sigma}, allowed: 0 N or more")
        if not (math.isfinite(time_constant) and time_constant >= 0.0):
            raise RangeError(f"time_constant is {time_constant}, allowed: 0 s or more")
        self._sigma = sigma
        self._time_constant = time_constant
        self._seed = seed
        self._dice: list[np.random.Generator] = []
        self._force = np.zeros((0, 3))

    def step(self, count: int, dt: float) -> NDArray[np.float64]:
        """Return the force on each of `count` drones during the next `dt` seconds (N), shape (count, 3)."""
        while len(self._dice) < count:
            dice = np.random.default_rng([self._seed, len(self._dice)])
            self._dice.append(dice)
            self._force = np.vstack([self._force, self._sigma * dice.standard_normal(3)])
        force = self._force[:count].copy()
        keep = math.exp(-dt / self._time_constant) if self._time_constant > 0.0 else 0.0
        fresh = np.array([dice.standard_normal(3) for dice in self._dice[:count]])
        self._force[:count] = keep * force + self._sigma * math.sqrt(1.0 - keep * keep) * fresh
        return force
