r"""Aggregative gradient tracking (docs/reference/crazychoir.md#8.3).

Each agent has a decision of its own, and costs that also depend on the mean of all decisions:
minimize :math:`\sum_i f_i(x_i, \sigma)` with :math:`\sigma = \frac{1}{N} \sum_j x_j`.

.. math::
    x_i^+ &= x_i - \alpha (\nabla_1 f_i(x_i, s_i) + y_i) \\
    s_i^+ &= \sum_j w_{ij} s_j + x_i^+ - x_i \\
    y_i^+ &= \sum_j w_{ij} y_j + \nabla_2 f_i(x_i^+, s_i^+) - \nabla_2 f_i(x_i, s_i)
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from crazychoir_fw.guidance.optimization.agent import Agent
from crazychoir_fw.guidance.optimization.algorithm import Algorithm, Array, positive, vector
from crazychoir_fw.guidance.optimization.flow_updating import FlowUpdating


class AggregativeProblem(Protocol):
    r"""One agent's cost :math:`f_i(x, \sigma)`."""

    def gradients(self, x: Array, sigma: Array) -> tuple[Array, Array]:
        """Return the gradients by own decision and by mean, each of shape (n,)."""


class AggregativeTracking(Algorithm):
    """Tracks the mean of all decisions and of the costs' gradients by it, in any dimension.

    The agent's problem may be changed between rounds (`set_problem`): moving optima are followed. Lost messages bias
    the tracked means; `RobustAggregativeTracking` bears them.

    Attributes:
        x: Own decision, shape (n,).
        s: What the agent thinks the mean of all decisions is, shape (n,).
        y: What it thinks the mean of the gradients by the mean is, shape (n,).
    """

    def __init__(
        self, agent: Agent, initial_condition: ArrayLike, enable_log: bool = False, *, stepsize: float = 1e-3
    ) -> None:
        """Begin.

        Args:
            agent: The agent that runs it, with an `AggregativeProblem` and doubly stochastic weights.
            initial_condition: Own decision at the begin, shape (n,).
            enable_log: Remember the result of every round.
            stepsize: The step alpha.

        Raises:
            RangeError: If the step is not above zero.
            StateError: If the agent has no problem.
        """
        super().__init__(agent, enable_log)
        self.x = vector("initial_condition", initial_condition)
        self.stepsize = positive("stepsize", stepsize)
        self.s = self.x
        self._by_mean = self._gradients()[1]
        self.y = self._by_mean

    def _gradients(self) -> tuple[Array, Array]:
        by_own, by_mean = self.agent.needed_problem(type(self).__name__).gradients(self.x, self.s)
        return np.asarray(by_own, dtype=np.float64), np.asarray(by_mean, dtype=np.float64)

    def _message(self) -> Array:
        return np.stack([self.s, self.y])

    def _update(self, received: Mapping[int, Any]) -> None:
        s, y = self._mixed(np.stack([self.s, self.y]), received)
        x = self.x - self.stepsize * (self._gradients()[0] + self.y)
        self.s = s + x - self.x
        self.x = x
        # by what was added before, not by what the present problem would have added: the sum stays right when it moves
        by_mean = self._gradients()[1]
        self.y = y + by_mean - self._by_mean
        self._by_mean = by_mean

    def get_result(self) -> Array:
        """Return the own decision, shape (n,)."""
        return self.x.copy()


class RobustAggregativeTracking(AggregativeTracking):
    """The same in asynchronous mode and with lost messages: means by `FlowUpdating`; undirected graphs, no weights.

    There is no published proof for this combination; the tests find the optimum with a fifth of all messages lost.
    """

    def __init__(
        self, agent: Agent, initial_condition: ArrayLike, enable_log: bool = False, *, stepsize: float = 1e-3
    ) -> None:
        """Begin; arguments and errors are those of `AggregativeTracking`."""
        super().__init__(agent, initial_condition, enable_log, stepsize=stepsize)
        self._flows = FlowUpdating(agent.all_in_neighbors, 2 * self.x.size)

    def leave(self, neighbors: Iterable[int]) -> None:
        """Go on without some neighbors, until messages of them arrive again."""
        for one in neighbors:
            self._flows.forget(one)
        self._look()

    def rejoin(self, neighbors: Iterable[int]) -> None:
        """Do nothing: a neighbor counts as soon as its message arrives."""

    def _message(self) -> dict[int, Array]:
        messages = self._flows.level(self._values())
        self._look()
        return messages

    def _update(self, received: Mapping[int, Any]) -> None:
        self._flows.take(self.agent.id, received)
        self._look()
        self.x = self.x - self.stepsize * (self._gradients()[0] + self.y)
        self._look()
        self._by_mean = self._gradients()[1]
        self._look()

    def _values(self) -> Array:
        return np.concatenate([self.x, self._by_mean])

    def _look(self) -> None:
        """Take the means from own values and flows."""
        self.s, self.y = self._flows.estimate(self._values()).reshape(2, -1)
