r"""Average consensus: :math:`x_i^+ = \sum_j w_{ij} x_j`."""

from __future__ import annotations

from collections.abc import Mapping

from numpy.typing import ArrayLike

from crazychoir_fw.guidance.optimization.agent import Agent
from crazychoir_fw.guidance.optimization.algorithm import Algorithm, Array, vector


class Consensus(Algorithm):
    """All agents come to one value: the mean of the initial ones where weights are doubly stochastic.

    A lost message is made up for by the own value: agents still agree, but on something else than the mean.
    `PushSumConsensus` finds the mean nevertheless.
    """

    def __init__(self, agent: Agent, initial_condition: ArrayLike, enable_log: bool = False) -> None:
        """Begin at a value of any shape, the same shape for all."""
        super().__init__(agent, enable_log)
        self.x = vector("initial_condition", initial_condition)

    def _message(self) -> Array:
        return self.x

    def _update(self, received: Mapping[int, Array]) -> None:
        self.x = self._mixed(self.x, received)

    def get_result(self) -> Array:
        """Return the present value."""
        return self.x.copy()
