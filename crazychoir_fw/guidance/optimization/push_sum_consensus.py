"""Average consensus for directed graphs and for messages that get lost."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from crazychoir_fw.guidance.optimization.agent import Agent
from crazychoir_fw.guidance.optimization.algorithm import Algorithm, Array, vector
from crazychoir_fw.guidance.optimization.running_sums import RunningSums


class PushSumConsensus(Algorithm):
    """All agents find the mean of the initial values, each as a ratio of two sums; weights are not used."""

    def __init__(self, agent: Agent, initial_condition: ArrayLike, enable_log: bool = False) -> None:
        """Begin at a value of any shape, the same shape for all."""
        super().__init__(agent, enable_log)
        x = vector("initial_condition", initial_condition)
        self._shape = x.shape
        self._sums = RunningSums(np.append(x, 1.0), len(agent.all_out_neighbors))

    def _message(self) -> Array:
        return self._sums.message()

    def _update(self, received: Mapping[int, Array]) -> None:
        self._sums.take(received)

    def get_result(self) -> Array:
        """Return the present estimate of the mean."""
        return (self._sums.mass[:-1] / self._sums.mass[-1]).reshape(self._shape)
