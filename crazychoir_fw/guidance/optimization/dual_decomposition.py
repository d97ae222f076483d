r"""Dual decomposition: minimum of :math:`\sum_i f_i(x)` where every agent has constraints of its own.

.. math::
    x_i = \arg\min_{x \in X_i} f_i(x) + \mu_i^T x, \qquad \mu_i = \sum_j \lambda_{ij}, \qquad
    \lambda_{ij}^+ = \lambda_{ij} + \alpha (x_i - x_j)

over an undirected graph, from :math:`\lambda_{ij} = 0`: prices that make agents agree. The two ends of an edge pay
each other, :math:`\lambda_{ji} = -\lambda_{ij}`, or the sum of all prices would drift and the optimum with it. So the
end with the smaller number holds the price of the edge and tells the other end, which takes the same step from there:
in lock step both have the same, and where messages get lost the next one sets it right. What agents know of each other
is then old, which smaller steps make up for (bounded delays: Low, Lapsley 1999).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from crazychoir_fw.guidance.optimization.agent import Agent
from crazychoir_fw.guidance.optimization.algorithm import Algorithm, Array, positive


class DualDecomposition(Algorithm):
    """The agent's problem has `minimize(linear, curvature)` and `size`, such as `QuadraticProblem`.

    In lock step it converges for steps below 2 m / L, where all costs curve at least with m (the least eigenvalue of
    2 P) and L is the largest eigenvalue of the graph's Laplacian, at most twice the largest degree. For steps up to
    half of that, the points of all agents are together within c / sqrt(alpha m k) of the optimum after k rounds, where
    c is the length of the prices that are to be found.
    """

    def __init__(self, agent: Agent, enable_log: bool = False, *, stepsize: float = 0.1) -> None:
        """Begin.

        Args:
            agent: The agent that runs it.
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
        self._prices = {one: np.zeros(problem.size) for one in agent.all_in_neighbors}
        self.x: Array = problem.minimize()

    @property
    def price(self) -> Array:
        """What a unit of its point costs the agent, all edges together, shape (n,)."""
        return sum(self._prices.values(), np.zeros_like(self.x))

    def _message(self) -> tuple[Array, dict[int, Array]]:
        return self.x, dict(self._prices)

    def _update(self, received: Mapping[int, tuple[Array, Mapping[int, Array]]]) -> None:
        for one, (x, prices) in received.items():
            held = self._prices[one] if self.agent.id < one else -np.asarray(prices[self.agent.id])
            self._prices[one] = held + self.stepsize * (self.x - np.asarray(x))
        self.x = self.agent.problem.minimize(self.price)

    def get_result(self) -> Array:
        """Return the agent's point, which satisfies its own constraints, shape (n,)."""
        return self.x.copy()
