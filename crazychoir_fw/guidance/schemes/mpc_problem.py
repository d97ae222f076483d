"""One agent's finite-horizon problem of model predictive control, as a quadratic program in its inputs.

States x(0..T) of x(t+1) = A x(t) + B u(t) are eliminated, so that the program has T m variables:

    minimize    sum over t < T of x'Qx + u'Ru, and x(T)'P x(T)
    subject to  E x(t) <= f, G u(t) <= h,   and   H x(t) <= b(t) for what couples it to others (t = 1..T)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.optimization.quadratic import InfeasibleError, QuadraticProblem, solver

Array = NDArray[np.float64]

_SLACK_COST = 1e4  # per unit and per unit squared: no constraint is given up to save cost
_SLACK_CURVATURE = 1e2
_ENDLESS = 1e12  # a cost that has grown so far has no limit


@dataclass(frozen=True)
class Plan:
    """States and inputs ahead."""

    states: Array  # (T + 1, n)
    inputs: Array  # (T, m)
    violation: float = 0.0
    """By how much the coupling is exceeded, because it cannot be kept; 0 if it is."""


class MPCProblem:
    """The problem of one agent; everything that does not change is computed once."""

    def __init__(
        self,
        A: ArrayLike,
        B: ArrayLike,
        Q: ArrayLike,
        R: ArrayLike,
        horizon: int,
        *,
        E: ArrayLike | None = None,
        f: ArrayLike | None = None,
        G: ArrayLike | None = None,
        h: ArrayLike | None = None,
    ) -> None:
        """Choose it.

        Args:
            A: Dynamics, shape (n, n).
            B: The same, shape (n, m).
            Q: Cost of states, positive semidefinite, shape (n, n).
            R: Cost of inputs, positive definite, shape (m, m).
            horizon: Steps that are looked ahead, T.
            E: Constraints on states, shape (any, n).
            f: Their right sides.
            G: Constraints on inputs, shape (any, m).
            h: Their right sides.

        Raises:
            RangeError: If shapes do not fit, or there is no stabilizing gain.
            MissingLibraryError: If there is no solver for constraints, which is better known now than in flight.
        """
        solver()
        self.A, self.B, self.Q, self.R = (np.atleast_2d(np.asarray(part, np.float64)) for part in (A, B, Q, R))
        n, m = self.B.shape
        for name, shape, wanted in (
            ("A", self.A.shape, (n, n)),
            ("Q", self.Q.shape, (n, n)),
            ("R", self.R.shape, (m, m)),
        ):
            if shape != wanted:
                raise RangeError(f"MPC: {name} has shape {shape}, allowed: {wanted} as B has shape {(n, m)}")
        if not 1 <= horizon <= 200:
            raise RangeError(f"MPC: horizon is {horizon}, allowed: 1 to 200")
        self.horizon = int(horizon)
        self.E, self.f = _rows("E", E, f, n)
        self.G, self.h = _rows("G", G, h, m)
        self.P, self.K = lqr(self.A, self.B, self.Q, self.R)
        self._condense()

    def _condense(self) -> None:
        """Make the matrices that take the first state and all inputs to the states x(1..T)."""
        n, m = self.B.shape
        steps = self.horizon
        powers = [np.eye(n)]
        for _ in range(steps):
            powers.append(self.A @ powers[-1])
        self._free = np.vstack(powers[1:])
        self._forced = np.zeros((steps * n, steps * m))
        for t in range(steps):
            for s in range(t + 1):
                self._forced[t * n : (t + 1) * n, s * m : (s + 1) * m] = powers[t - s] @ self.B
        weights = np.kron(np.eye(steps), self.Q)
        weights[-n:, -n:] = self.P
        self._hessian = self._forced.T @ weights @ self._forced + np.kron(np.eye(steps), self.R)
        self._slope = 2.0 * self._forced.T @ weights @ self._free
        self._inputs_left = np.kron(np.eye(steps), self.G)
        self._inputs_right = np.tile(self.h, steps)
        self._states_left = np.kron(np.eye(steps), self.E)

    def solve(self, x: ArrayLike, H: ArrayLike | None = None, b: ArrayLike | None = None) -> Plan:
        """Return the best plan from a state.

        What couples an agent to others, and constraints on states, are exceeded as little as possible where they cannot
        be kept; constraints on inputs always hold.

        Args:
            x: State now, shape (n,).
            H: Coupling, shape (c, n).
            b: Its right sides, infinite where there is none, shape (T, c): for x(1) to x(T).

        Raises:
            RangeError: If shapes do not fit.
            InfeasibleError: If constraints on inputs contradict each other.
        """
        x = np.asarray(x, np.float64).reshape(-1)
        soft_left, soft_right = self._coupled(x, H, b)
        hard = (self._inputs_left, self._inputs_right)
        try:
            u = QuadraticProblem(
                self._hessian,
                self._slope @ x,
                A=np.vstack([hard[0], soft_left]),
                b=np.concatenate([hard[1], soft_right]),
            ).minimize()
            violation = 0.0
        except InfeasibleError:
            u, violation = self._with_slack(x, *hard, soft_left, soft_right)
        return Plan(self.states(x, u), u.reshape(self.horizon, -1), violation)

    def _coupled(self, x: Array, H: ArrayLike | None, b: ArrayLike | None) -> tuple[Array, Array]:
        left = [self._states_left @ self._forced]
        right = [np.tile(self.f, self.horizon) - self._states_left @ self._free @ x]
        if H is not None and b is not None:
            rows = np.atleast_2d(np.asarray(H, np.float64))
            sides = np.asarray(b, np.float64).reshape(-1)
            if sides.size != self.horizon * len(rows):
                raise RangeError(f"MPC: b has {sides.size} numbers, allowed: {self.horizon} times {len(rows)}")
            stacked = np.kron(np.eye(self.horizon), rows)
            counts = np.isfinite(sides)
            left.append((stacked @ self._forced)[counts])
            right.append((sides - stacked @ self._free @ x)[counts])
        return np.vstack(left), np.concatenate(right)

    def _with_slack(
        self, x: Array, hard: Array, hard_right: Array, soft: Array, soft_right: Array
    ) -> tuple[Array, float]:
        size = len(self._hessian)
        hessian = np.zeros((size + 1, size + 1))
        hessian[:size, :size] = self._hessian
        hessian[size, size] = _SLACK_CURVATURE
        slope = np.append(self._slope @ x, _SLACK_COST)
        left = np.zeros((len(hard) + len(soft) + 1, size + 1))
        left[: len(hard), :size] = hard
        left[len(hard) : -1, :size] = soft
        left[len(hard) :, size] = -1.0
        found = QuadraticProblem(hessian, slope, A=left, b=np.concatenate([hard_right, soft_right, [0.0]])).minimize()
        return found[:size], max(0.0, float(found[size]))

    def states(self, x: ArrayLike, u: ArrayLike) -> Array:
        """Return the states x(0..T) of inputs, shape (T + 1, n)."""
        x = np.asarray(x, np.float64).reshape(-1)
        ahead = self._free @ x + self._forced @ np.asarray(u, np.float64).reshape(-1)
        return np.vstack([x, ahead.reshape(self.horizon, -1)])

    def cost(self, plan: Plan) -> float:
        """Return what a plan costs."""
        x, u = plan.states, plan.inputs
        running = np.einsum("ti,ij,tj->", x[:-1], self.Q, x[:-1]) + np.einsum("ti,ij,tj->", u, self.R, u)
        return float(running + x[-1] @ self.P @ x[-1])

    def shifted(self, states: Array) -> Array:
        """Return states one step later, with a last one by the gain of the regulator, shape (T + 1, n)."""
        return np.vstack([states[1:], (self.A + self.B @ self.K) @ states[-1]])


def lqr(A: Array, B: Array, Q: Array, R: Array) -> tuple[Array, Array]:
    """Return cost P and gain K of the regulator u = K x that minimizes the sum of x'Qx + u'Ru.

    Raises:
        RangeError: If the iteration of Riccati finds none.
    """
    P = np.array(Q)
    for _ in range(10_000):
        K = -np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A)
        following = Q + A.T @ P @ (A + B @ K)
        following = (following + following.T) / 2.0
        if not np.abs(following).max() < _ENDLESS:
            break
        if np.abs(following - P).max() <= 1e-12 * max(1.0, float(np.abs(P).max())):
            return following, K
        P = following
    raise RangeError("MPC: there is no regulator for A, B, Q, R, allowed: a system that inputs can stabilize")


def _rows(name: str, left: ArrayLike | None, right: ArrayLike | None, size: int) -> tuple[Array, Array]:
    if left is None or right is None:
        return np.zeros((0, size)), np.zeros(0)
    rows, sides = np.atleast_2d(np.asarray(left, np.float64)), np.asarray(right, np.float64).reshape(-1)
    if rows.shape != (len(sides), size):
        raise RangeError(f"MPC: {name} has shape {rows.shape}, allowed: {(len(sides), size)}")
    return rows, sides
