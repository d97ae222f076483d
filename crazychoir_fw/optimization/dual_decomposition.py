r"""Dual decomposition: minimum of :math:`\sum_i f_i(x)` where every agent has constraints of its own.

.. math::
    x_i = \arg\min_{x \in X_i} f_i(x) + \mu_i^T x, \qquad \mu_i^+ = \mu_i + \alpha \sum_j (x_i - x_j)

over an undirected graph, from :math:`\mu_i = 0`: prices that make agents agree. Both ends of an edge must take the same
step, so that rounds are in lock step and no message may be lost; undirected graphs that change are fine. `ADMM` bears
losses.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from crazychoir_fw.optimization.agent import Agent
from crazychoir_fw.optimization.algorithm import Algorithm, Array, positive


class DualDecomposition(Algorithm):
    """The agent's problem has `minimize(linear, curvature)` and `size`, such as `QuadraticProblem`.

    It converges for steps below 2 m / L, where all costs curve at least with m (the least eigenvalue of 2 P) and L is
    the largest eigenvalue of the graph's Laplacian, at most twice the largest degree.
    """

    def __init__(self, agent: Agent, enable_log: bool = False, *, stepsize: float = 0.1) -> None:
        """Begin.

        Args:
            agent: Who runs it.
            enable_log: Remember the result of every round.
            stepsize: The step alpha.

        Raises:
            InfeasibleError: If no point satisfies the agent's constraints.
            RangeError: If its cost is flat in some direction, or the step is not above zero.
            StateError: If it has no problem.
        """
        super().__init__(agent, enable_log)
        self.stepsize = positive("stepsize", stepsize)
        problem = agent.needed_problem("DualDecomposition")
        self.price = np.zeros(problem.size)
        self.x: Array = problem.minimize()

    def _message(self) -> Array:
        return self.x

    def _update(self, received: Mapping[int, Array]) -> None:
        for one in sorted(received):
            self.price = self.price + self.stepsize * (self.x - received[one])
        self.x = self.agent.problem.minimize(self.price)

    def get_result(self) -> Array:
        """Return the agent's point, which satisfies its own constraints, shape (n,)."""
        return self.x.copy()
