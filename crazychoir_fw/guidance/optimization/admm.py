r"""ADMM: minimum of :math:`\sum_i f_i(x)` with constraints of each agent; lost messages only slow it down.

For every neighbor j an agent holds :math:`z_{ij}`:

.. math::
    x_i = \arg\min_{x \in X_i} f_i(x) + \tfrac{\rho d_i}{2} |x|^2 - x^T \sum_j z_{ij}, \qquad
    z_{ji}^+ = (1 - \gamma) z_{ji} + \gamma (2 \rho x_i - z_{ij})

(relaxed ADMM over edges: Bastianello, Carli, Schenato, Todescato 2021). The last line is done by j with the message
of i; where that is lost, z stays. It converges with random losses and in asynchronous mode, for all convex costs.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.optimization.agent import Agent
from crazychoir_fw.guidance.optimization.algorithm import Algorithm, Array, positive


class ADMM(Algorithm):
    """The agent's problem has `minimize(linear, curvature)` and `size`, such as `QuadraticProblem`.

    Graphs are undirected: both ends of an edge hear each other.
    """

    def __init__(
        self, agent: Agent, enable_log: bool = False, *, penalty: float = 1.0, relaxation: float = 0.5
    ) -> None:
        """Begin.

        Args:
            agent: The agent that runs it.
            enable_log: Remember the result of every round.
            penalty: The number rho, any above zero; how fast it converges depends on it.
            relaxation: The number gamma, (0, 1]; 1/2 is the classic ADMM; 1 does not always converge.

        Raises:
            InfeasibleError: If no point satisfies the agent's constraints.
            RangeError: If a number is outside its range.
            StateError: If the agent has no problem.
        """
        super().__init__(agent, enable_log)
        self.penalty = positive("penalty", penalty)
        if not 0.0 < relaxation <= 1.0:
            raise RangeError(f"relaxation is {relaxation}, allowed: above 0, at most 1")
        self.relaxation = relaxation
        self._problem = agent.needed_problem("ADMM")
        self._z = {one: np.zeros(self._problem.size) for one in agent.all_in_neighbors}
        self.x: Array = self._minimum()

    def _minimum(self) -> Array:
        problem = self.agent.problem
        if not self._z:
            return problem.minimize()
        return problem.minimize(-sum(self._z.values()), self.penalty * len(self._z))

    def _message(self) -> dict[int, Array]:
        return {one: 2.0 * self.penalty * self.x - z for one, z in self._z.items()}

    def _update(self, received: Mapping[int, Mapping[int, Array]]) -> None:
        keep = 1.0 - self.relaxation
        for one, messages in received.items():
            self._z[one] = keep * self._z[one] + self.relaxation * messages[self.agent.id]
        self.x = self._minimum()

    def get_result(self) -> Array:
        """Return the agent's point, which satisfies its own constraints, shape (n,)."""
        return self.x.copy()
