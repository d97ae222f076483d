r"""Gradient tracking: minimum of :math:`\sum_i f_i(x)` over undirected graphs.

.. math::
    x_i^+ = \sum_j w_{ij} x_j - \alpha y_i, \qquad
    y_i^+ = \sum_j w_{ij} y_j + \nabla f_i(x_i^+) - \nabla f_i(x_i), \qquad y_i(0) = \nabla f_i(x_i(0))

With doubly stochastic weights, also over undirected graphs that change and are jointly connected. A lost message breaks
the sum that is tracked: `DirectedGradientTracking` bears that.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from crazychoir_fw.guidance.optimization.agent import Agent
from crazychoir_fw.guidance.optimization.algorithm import Algorithm, Array, positive, vector


class GradientTracking(Algorithm):
    """The agent's problem has `gradient(x)`; the minimum of the sum of all costs is found at a linear rate."""

    def __init__(
        self, agent: Agent, initial_condition: ArrayLike, enable_log: bool = False, *, stepsize: float = 0.1
    ) -> None:
        """Begin.

        Args:
            agent: The agent that runs it, with a problem such as `QuadraticProblem`.
            initial_condition: Where it begins, shape (n,).
            enable_log: Remember the result of every round.
            stepsize: The step alpha; small against 1/L for costs whose gradients have the Lipschitz constant L.

        Raises:
            RangeError: If the step is not above zero.
            StateError: If the agent has no problem.
        """
        super().__init__(agent, enable_log)
        self.x = vector("initial_condition", initial_condition)
        self.stepsize = positive("stepsize", stepsize)
        self._gradient = self._gradient_at(self.x)
        self.y = self._gradient

    def _gradient_at(self, x: Array) -> Array:
        return np.asarray(self.agent.needed_problem(type(self).__name__).gradient(x), dtype=np.float64)

    def _message(self) -> tuple[Array, Array]:
        return self.x, self.y

    def _update(self, received: Mapping[int, tuple[Array, Array]]) -> None:
        both = self._mixed(np.stack([self.x, self.y]), {one: np.stack(pair) for one, pair in received.items()})
        self.x = both[0] - self.stepsize * self.y
        gradient = self._gradient_at(self.x)
        self.y = both[1] + gradient - self._gradient
        self._gradient = gradient

    def get_result(self) -> Array:
        """Return the present estimate of the minimum, shape (n,)."""
        return self.x.copy()
