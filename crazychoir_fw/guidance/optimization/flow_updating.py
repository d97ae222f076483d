"""A mean of values that may change, over undirected graphs, with messages that may get lost.

No agent hands its value over: an agent keeps, for each neighbor, the flow to it. Its estimate of the mean is its value
less all flows. Both ends of an edge hold the same flow with opposite signs; a message carries the whole
flow, so that any later one makes up for a lost one (flow updating: Jesus, Baquero, Almeida 2009).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class FlowUpdating:
    """The flows of one agent; values are vectors of one length for all."""

    def __init__(self, neighbors: Iterable[int], size: int) -> None:
        """Begin without flows.

        Args:
            neighbors: All that it may ever exchange with.
            size: Length of the values.
        """
        self._flows = {one: np.zeros(size) for one in neighbors}
        self._estimates: dict[int, Array] = {}

    def estimate(self, value: Array) -> Array:
        """Return the agent's estimate of the mean, for its own value."""
        return value - sum(self._flows.values())

    def level(self, value: Array) -> dict[int, Array]:
        """Set flows that give all neighbors with a message the same estimate; return the message for each."""
        own = self.estimate(value)
        mean = np.mean([own, *self._estimates.values()], axis=0)
        for one, estimate in self._estimates.items():
            self._flows[one] = self._flows[one] + mean - estimate
            self._estimates[one] = mean
        return {one: np.stack([flow, mean]) for one, flow in self._flows.items()}

    def take(self, agent: int, received: Mapping[int, Mapping[int, Array]]) -> None:
        """Take over what neighbors say.

        Args:
            agent: Number of the agent that owns these flows.
            received: Messages of `level` by neighbor.
        """
        for one, messages in received.items():
            flow, self._estimates[one] = np.array(messages[agent])
            self._flows[one] = -flow

    def forget(self, one: int) -> None:
        """Go on without a neighbor and take its flow back; a later message of it sets the flow again."""
        self._flows[one] = np.zeros_like(self._flows[one])
        self._estimates.pop(one, None)
