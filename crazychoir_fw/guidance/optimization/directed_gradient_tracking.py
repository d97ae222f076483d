r"""Gradient tracking for directed graphs and for messages that get lost or come in any order of rounds.

Estimates are mixed by rows, gradients by running sums (`RunningSums`), as in push-pull and ASY-SONATA (Tian, Sun,
Scutari 2020):

.. math::
    x_i^+ = \sum_j a_{ij} (x_j - \alpha y_j), \qquad
    y_i^+ = \text{kept part of } y_i + \text{parts received from others} + \nabla f_i(x_i^+) - \nabla f_i(x_i)

where the latest message of j stands for j.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from crazychoir_fw.guidance.optimization.agent import Agent
from crazychoir_fw.guidance.optimization.algorithm import Algorithm, Array, positive, vector
from crazychoir_fw.guidance.optimization.running_sums import RunningSums


class DirectedGradientTracking(Algorithm):
    """The agent's problem has `gradient(x)`. Weights are not used: all agents count the same."""

    def __init__(
        self, agent: Agent, initial_condition: ArrayLike, enable_log: bool = False, *, stepsize: float = 0.05
    ) -> None:
        """Begin; arguments and errors are those of `GradientTracking`, the step is smaller where messages get lost."""
        super().__init__(agent, enable_log)
        self.x = vector("initial_condition", initial_condition)
        self.stepsize = positive("stepsize", stepsize)
        self._gradient = self._gradient_at(self.x)
        self._sums = RunningSums(self._gradient, len(agent.all_out_neighbors))
        self._stepped = self.x
        self._heard: dict[int, Array] = {}

    @property
    def y(self) -> Array:
        """Tracked gradient, shape (n,)."""
        return self._sums.mass

    def _gradient_at(self, x: Array) -> Array:
        return np.asarray(self.agent.needed_problem(type(self).__name__).gradient(x), dtype=np.float64)

    def _message(self) -> tuple[Array, Array]:
        self._stepped = self.x - self.stepsize * self._sums.mass
        return self._stepped, self._sums.message()

    def _update(self, received: Mapping[int, tuple[Array, Array]]) -> None:
        self._sums.take({one: total for one, (_, total) in received.items()})
        self._heard.update({one: np.array(stepped) for one, (stepped, _) in received.items()})
        self.x = np.mean([self._stepped, *self._heard.values()], axis=0)
        gradient = self._gradient_at(self.x)
        self._sums.mass = self._sums.mass + gradient - self._gradient
        self._gradient = gradient

    def get_result(self) -> Array:
        """Return the present estimate of the minimum, shape (n,)."""
        return self.x.copy()
