"""Constraints consensus: one cost that all know, constraints that each agent has for itself.

Agents tell each other the few constraints that hold their optimum in place (a basis, at most as many as variables).
Each solves the problem with its own constraints and all bases it heard, and keeps the new basis. After finitely many
rounds all have the optimum of all constraints (Notarstefano, Bullo 2011). It works over directed graphs that change
and are jointly connected, asynchronously, and with lost messages.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from crazychoir_fw.guidance.optimization.agent import Agent
from crazychoir_fw.guidance.optimization.algorithm import Algorithm, Array
from crazychoir_fw.guidance.optimization.quadratic import InfeasibleError, QuadraticProblem

_SAME = 1e-9  # relative change of the optimum that is none


class ConstraintsConsensus(Algorithm):
    """The agent's problem is a `QuadraticProblem`: strictly convex cost, the same for all; inequalities of its own.

    Attributes:
        x: Optimum of the constraints that the agent knows of, shape (n,); none of `nan` where they contradict each
            other.
        is_feasible: Whether there is one. Once an agent finds a contradiction, all agents learn of it.
    """

    def __init__(self, agent: Agent, enable_log: bool = False, *, stop_iterations: int | None = None) -> None:
        """Begin.

        Args:
            agent: The agent that runs it.
            enable_log: Remember the result of every round.
            stop_iterations: Done after so many rounds without a change; twice the longest way between two agents and
                one more is enough in lock step. None: never.

        Raises:
            RangeError: If the cost is flat in some direction.
            StateError: If the agent has no problem.
        """
        super().__init__(agent, enable_log)
        self._problem: QuadraticProblem = agent.needed_problem("ConstraintsConsensus")
        self._stop_iterations = stop_iterations
        self._unchanged = 0
        self.is_feasible = True
        self.basis = np.zeros((0, self._problem.size + 1))
        self.x = np.full(self._problem.size, np.nan)
        self._solve([])

    def _solve(self, heard: list[Array]) -> None:
        problem = self._problem
        rows = np.vstack([np.column_stack([problem.A, problem.b]), self.basis, *heard])
        # sorted and without duplicates: agents that have the same rows solve the same problem
        rows = np.unique(rows, axis=0)
        try:
            self.x, active = problem.minimize_with_rows(rows[:, :-1], rows[:, -1])
        except InfeasibleError:
            self._give_up()
            return
        self.basis = rows[active]

    def _give_up(self) -> None:
        self.is_feasible = False
        self.x = np.full(self._problem.size, np.nan)

    def _message(self) -> Array | None:
        return self.basis if self.is_feasible else None

    def _update(self, received: Mapping[int, Array | None]) -> None:
        before, was_feasible = self.x, self.is_feasible
        heard = [one for one in received.values() if one is not None]
        if len(heard) < len(received):
            self._give_up()
        if self.is_feasible:
            self._solve(heard)
        same = np.allclose(before, self.x, rtol=_SAME, atol=_SAME, equal_nan=True) and was_feasible == self.is_feasible
        self._unchanged = self._unchanged + 1 if same else 0

    @property
    def is_done(self) -> bool:
        """Whether nothing changed for as many rounds as were asked for."""
        return self._stop_iterations is not None and self._unchanged >= self._stop_iterations

    def get_result(self) -> Array:
        """Return the optimum of the constraints that the agent knows of, shape (n,)."""
        return self.x.copy()
