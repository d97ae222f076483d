r"""Max consensus: :math:`x_i^+ = \max_j x_j`, entry by entry."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from crazychoir_fw.guidance.optimization.agent import Agent
from crazychoir_fw.guidance.optimization.algorithm import Algorithm, Array, vector


class MaxConsensus(Algorithm):
    """All agents find the largest initial value, after as many rounds as the graph is wide; losses only delay it."""

    def __init__(
        self, agent: Agent, x0: ArrayLike, graph_diameter: int | None = None, enable_log: bool = False
    ) -> None:
        """Begin.

        Args:
            agent: The agent that runs it.
            x0: Initial value of any shape, the same shape for all.
            graph_diameter: Longest way between two agents; after so many rounds without a lost message it is done.
                None: never.
            enable_log: Remember the result of every round.
        """
        super().__init__(agent, enable_log)
        self.x = vector("x0", x0)
        self._diameter = graph_diameter

    def _message(self) -> Array:
        return self.x

    def _update(self, received: Mapping[int, Array]) -> None:
        self.x = np.max([self.x, *received.values()], axis=0)

    @property
    def is_done(self) -> bool:
        """Whether as many rounds are over as the graph is wide."""
        return self._diameter is not None and self.rounds >= self._diameter

    def get_result(self) -> Array:
        """Return the largest value so far."""
        return self.x.copy()
