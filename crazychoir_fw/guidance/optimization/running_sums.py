"""Sums that survive lost messages: the next message that arrives also carries the content of the lost ones.

Every agent splits its mass in equal shares for itself and its out-neighbors, and sends the sum of all shares so far. A
receiver adds what is new in that sum. Nothing is counted twice or lost for good, whichever messages arrive, so that the
total of all agents and of what is on its way never changes (robust push-sum: Hadjicostis, Vaidya, Dominguez-Garcia
2016).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class RunningSums:
    """The mass of one agent."""

    def __init__(self, mass: Array, receivers: int) -> None:
        """Begin.

        Args:
            mass: What the agent has, a vector.
            receivers: Number of out-neighbors, in the largest graph.
        """
        self.mass = mass.copy()
        self._parts = receivers + 1
        self._sent = np.zeros_like(self.mass)
        self._heard: dict[int, Array] = {}

    def message(self) -> Array:
        """Give shares away; return the sum of all shares of one receiver so far."""
        self.mass = self.mass / self._parts
        self._sent = self._sent + self.mass
        return self._sent

    def take(self, received: Mapping[int, Array]) -> None:
        """Add what is new in the sums that came."""
        for one, total in received.items():
            self.mass = self.mass + total - self._heard.get(one, 0.0)
            self._heard[one] = np.array(total)
