"""Costs that are quadratic, over sets that linear inequalities and equations describe."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import CrazychoirError, MissingLibraryError, RangeError
from crazychoir_fw.guidance.optimization.algorithm import vector

Array = NDArray[np.float64]


class InfeasibleError(CrazychoirError, ValueError):
    """No point satisfies all constraints."""


def solver() -> Any:
    """Return the exact solver of small quadratic programs.

    Raises:
        MissingLibraryError: If it is not installed.
    """
    try:
        import quadprog
    except ImportError as error:
        raise MissingLibraryError("constraints need quadprog: run pip install 'crazychoir-fw[optimization]'") from error
    return quadprog


class QuadraticProblem:
    r"""One agent's part: cost :math:`x^T P x + q^T x + r` (no factor 1/2) where :math:`A x \le b`, :math:`E x = f`."""

    def __init__(
        self,
        P: ArrayLike,
        q: ArrayLike,
        r: float = 0.0,
        *,
        A: ArrayLike | None = None,
        b: ArrayLike | None = None,
        E: ArrayLike | None = None,
        f: ArrayLike | None = None,
    ) -> None:
        """Choose it.

        Args:
            P: Positive semidefinite, shape (n, n).
            q: Shape (n,).
            r: A number.
            A: Inequalities, shape (m, n).
            b: Their right sides, shape (m,).
            E: Equations, shape (k, n).
            f: Their right sides, shape (k,).

        Raises:
            RangeError: If shapes do not fit, or P has a negative eigenvalue.
        """
        self.q = vector("q", q).reshape(-1)
        n = self.q.size
        self.P = np.atleast_2d(vector("P", P))
        if self.P.shape != (n, n):
            raise RangeError(f"quadratic problem: P has shape {np.shape(P)}, allowed: {(n, n)}, as q has {n} entries")
        self.P = (self.P + self.P.T) / 2.0
        if np.linalg.eigvalsh(self.P)[0] < -1e-9 * max(1.0, float(np.abs(self.P).max())):
            raise RangeError("quadratic problem: P has a negative eigenvalue, allowed: positive semidefinite")
        self.r = float(r)
        self.A, self.b = _rows("A", A, "b", b, n)
        self.E, self.f = _rows("E", E, "f", f, n)

    @property
    def size(self) -> int:
        """Number of variables."""
        return self.q.size

    def value(self, x: Array) -> float:
        """Return the cost."""
        return float(x @ self.P @ x + self.q @ x + self.r)

    def gradient(self, x: Array) -> Array:
        """Return the gradient of the cost, shape (n,)."""
        return 2.0 * self.P @ x + self.q

    def minimize(self, linear: Array | float = 0.0, curvature: float = 0.0) -> Array:
        r"""Return where :math:`x^T P x + q^T x + linear^T x + curvature |x|^2 / 2` is least within the constraints.

        Raises:
            InfeasibleError: If no point satisfies the constraints.
            RangeError: If the cost is flat in some direction.
        """
        return self.minimize_with_rows(self.A, self.b, linear, curvature)[0]

    def minimize_with_rows(
        self, A: Array, b: Array, linear: Array | float = 0.0, curvature: float = 0.0
    ) -> tuple[Array, NDArray[np.intp]]:
        """Do the same with other inequalities; return the point and which of them hold it there.

        Those rows are linearly independent, and without all others the point is the same.
        """
        hessian = 2.0 * self.P + curvature * np.eye(self.size)
        slope = np.broadcast_to(self.q + linear, (self.size,))
        try:
            if not len(b) and not len(self.f):
                np.linalg.cholesky(hessian)
                return np.linalg.solve(hessian, -slope), np.zeros(0, dtype=np.intp)
            rows = np.vstack([self.E, -A])
            right = np.concatenate([self.f, -b])
            if np.linalg.cond(hessian) > 1e12:
                raise RangeError(_FLAT)
            found = solver().solve_qp(hessian, -slope, rows.T.copy(), right, len(self.f))
        except np.linalg.LinAlgError as error:
            raise RangeError(_FLAT) from error
        except ValueError as error:
            if "inconsistent" in str(error):
                raise InfeasibleError("quadratic problem: no point satisfies all constraints") from error
            if "positive definite" in str(error):
                raise RangeError(_FLAT) from error
            raise
        active = np.asarray(found[5], dtype=np.intp) - 1 - len(self.f)
        return found[0], np.sort(active[active >= 0])


_FLAT = "quadratic problem: the cost is flat in some direction, allowed: strictly convex"


def _rows(left: str, A: ArrayLike | None, right: str, b: ArrayLike | None, n: int) -> tuple[Array, Array]:
    if A is None and b is None:
        return np.zeros((0, n)), np.zeros(0)
    if A is None or b is None:
        raise RangeError(f"quadratic problem: only one of {left} and {right} is given, allowed: both or none")
    rows = np.array(A, dtype=np.float64)
    if rows.ndim != 2 or rows.shape[1] != n:
        raise RangeError(f"quadratic problem: {left} has shape {rows.shape}, allowed: (any, {n})")
    sides = np.array(b, dtype=np.float64).reshape(-1)
    if len(rows) != len(sides):
        raise RangeError(f"quadratic problem: {left} has {len(rows)} rows, {right} has {len(sides)} entries")
    if not (np.all(np.isfinite(rows)) and np.all(np.isfinite(sides))):
        raise RangeError(f"quadratic problem: {left} and {right} must hold finite numbers")
    return rows, sides
