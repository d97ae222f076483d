"""Distributed simplex: a linear program whose columns the agents share (docs/reference/crazychoir.md#18).

Minimize c^T x where A x = b, x >= 0; each agent knows b and has some of the columns. Agents tell each other their best
bases; each solves the program of its own columns and all bases it heard. The lexicographic rules leave one best basis
only, to which all come after finitely many rounds (Buerger, Notarstefano, Bullo, Allgoewer 2012), over directed graphs
that change and are jointly connected, asynchronously, and with lost messages.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.optimization import lexicographic
from crazychoir_fw.guidance.optimization.agent import Agent
from crazychoir_fw.guidance.optimization.algorithm import Algorithm, Array, positive, vector


class LinearProblem:
    """One agent's columns of a linear program."""

    def __init__(self, costs: ArrayLike, columns: ArrayLike, b: ArrayLike) -> None:
        """Choose it.

        Args:
            costs: Cost of each of its variables, shape (n,); n may be 0.
            columns: Their columns of A, shape (m, n).
            b: Right side, the same for all agents, shape (m,).

        Raises:
            RangeError: If shapes do not fit, or a number is not finite.
        """
        self.b = vector("b", b).reshape(-1)
        self.costs = np.array(costs, dtype=np.float64).reshape(-1)
        self.columns = np.array(columns, dtype=np.float64)
        if self.columns.ndim != 2 or len(self.columns) != len(self.b):
            raise RangeError(
                f"linear problem: columns have shape {self.columns.shape}, allowed: ({len(self.b)}, any) as b"
            )
        if self.columns.shape[1] != len(self.costs):
            raise RangeError(
                f"linear problem: there are {len(self.costs)} costs and {self.columns.shape[1]} columns, "
                "allowed: as many"
            )
        if not (np.all(np.isfinite(self.costs)) and np.all(np.isfinite(self.columns))):
            raise RangeError("linear problem: costs and columns must hold finite numbers")


class DistributedSimplex(Algorithm):
    """The agent's problem is a `LinearProblem`.

    Attributes:
        B: Best basis, cost on top, shape (m + 1, m).
        x_basic: Values of the basis's variables, shape (m,).
        x_dual: Prices of the rows, shape (m,).
        J: Least cost of what the agent knows.
        big_M: Cost of leaving one unit of a row's right side without a column.
    """

    def __init__(
        self,
        agent: Agent,
        enable_log: bool = False,
        stop_iterations: int | None = None,
        big_M: float = 500.0,
    ) -> None:
        """Begin.

        Args:
            agent: The agent that runs it.
            enable_log: Remember the result of every round.
            stop_iterations: Done after so many rounds without a change; twice the longest way between two agents and
                one more is enough in lock step. None: never.
            big_M: Cost of leaving one unit of a row's right side without a column: more than any column is worth.

        Raises:
            RangeError: If big_M is not above zero.
            StateError: If the agent has no problem.
            UnboundedError: If the cost has no least value.
        """
        super().__init__(agent, enable_log)
        problem: LinearProblem = agent.needed_problem("DistributedSimplex")
        self._stop_iterations = stop_iterations
        self._unchanged = 0
        self.big_M = positive("big_M", big_M)
        # rows with a negative right side are turned round, the same by all, for b is common knowledge
        self._sign = np.where(problem.b < 0.0, -1.0, 1.0)
        self._b = np.abs(problem.b)
        m = len(self._b)
        self.B = np.vstack([np.full(m, self.big_M), np.eye(m)])
        self._own = np.vstack([problem.costs, problem.columns * self._sign[:, None]])
        self._solve([])

    def _solve(self, bases: list[Array]) -> None:
        best = lexicographic.solve(np.hstack([self._own, *bases]), self._b, self.B)
        self._unchanged = self._unchanged + 1 if np.array_equal(best.basis, self.B) else 0
        self.B, self.x_basic, self.J = best.basis, best.x, best.cost
        self.x_dual = best.prices * self._sign

    def _message(self) -> Array:
        return self.B

    def _update(self, received: Mapping[int, Array]) -> None:
        self._solve([received[one] for one in sorted(received)])

    @property
    def is_done(self) -> bool:
        """Whether nothing changed for as many rounds as were asked for."""
        return self._stop_iterations is not None and self._unchanged >= self._stop_iterations

    @property
    def artificial(self) -> Array:
        """Part of each row's right side that no column covers, shape (m,); not zero: infeasible so far."""
        left = np.zeros(len(self._b))
        for column, value in zip(self.B.T, self.x_basic, strict=True):
            if column[0] == self.big_M and np.count_nonzero(column[1:]) == 1 and column[1:].max() == 1.0:
                left[np.argmax(column[1:])] += value
        return left

    @property
    def is_feasible(self) -> bool:
        """Whether all rows are satisfied by columns that the agent knows."""
        return bool(np.all(self.artificial <= lexicographic.TOLERANCE))

    def get_result(self) -> tuple[Array, Array]:
        """Return best basis and values of its variables."""
        return self.B.copy(), self.x_basic.copy()
