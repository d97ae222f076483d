"""Linear programs with one and only one best basis: the simplex method with lexicographic rules.

Minimize c^T x where A x = b, x >= 0. Among equal costs the solution is taken whose entries, with columns in
lexicographic order, are lexicographically least; among bases of the same solution the one that stays feasible when b
is changed a little, the first row more than the second and so on. Both rules depend on nothing but the columns, so
that all agents with the same columns find the same basis.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import CrazychoirError, StateError

Array = NDArray[np.float64]

TOLERANCE = 1e-6
"""What counts as zero among reduced costs and directions (docs/reference/crazychoir.md#18)."""

_TIE = 1e-9
_MAX_PIVOTS = 10_000


class UnboundedError(CrazychoirError, ValueError):
    """The cost has no least value."""


@dataclass(frozen=True)
class Optimum:
    """A best basis."""

    basis: Array
    """Its columns, cost on top, in lexicographic order, shape (m + 1, m)."""
    x: Array
    """Values of its variables, shape (m,)."""
    cost: float
    """The least cost."""
    prices: Array
    """How much the cost grows with b (dual solution), shape (m,)."""


def distinct(columns: Array) -> Array:
    """Return the columns in lexicographic order, none twice, shape (m + 1, n)."""
    columns = columns + 0.0  # there is one zero only
    ordered = columns[:, np.lexsort(columns[::-1])]
    new = np.ones(ordered.shape[1], dtype=bool)
    new[1:] = np.any(ordered[:, 1:] != ordered[:, :-1], axis=0)
    return ordered[:, new]


def solve(columns: Array, b: Array, basis: Array) -> Optimum:
    """Find the best basis.

    Args:
        columns: Cost above the column of A, shape (m + 1, n).
        b: Right side, nothing negative, shape (m,).
        basis: Columns to begin with: those of an identity matrix, or the basis of an optimum for the same b, (m + 1,
            m).

    Raises:
        UnboundedError: If the cost has no least value.
        StateError: If 10,000 steps were not enough.
    """
    table = distinct(np.hstack([columns, basis]))
    c, A = table[0], table[1:]
    members = _places(table, basis)
    for _ in range(_MAX_PIVOTS):
        inverse = np.linalg.inv(A[:, members])
        x = inverse @ b
        prices = c[members] @ inverse
        entering = _entering(c - prices @ A, A, inverse, members)
        if entering is None:
            order = np.argsort(members)
            ordered = table[:, members[order]]
            return Optimum(ordered, x[order], float(c[members] @ x), prices)
        leaving = _leaving(inverse @ A[:, entering], x, inverse)
        members[leaving] = entering
    raise StateError(f"simplex: {_MAX_PIVOTS} steps were not enough")


def _places(table: Array, basis: Array) -> NDArray[np.intp]:
    found = {column.tobytes(): place for place, column in enumerate(np.ascontiguousarray(table.T))}
    return np.array([found[column.tobytes()] for column in np.ascontiguousarray((basis + 0.0).T)], dtype=np.intp)


def _entering(reduced: Array, A: Array, inverse: Array, members: NDArray[np.intp]) -> int | None:
    """Return a column that makes the cost less, or else the solution lexicographically less; None: it is the best."""
    reduced[members] = np.inf
    best = int(np.argmin(reduced))
    if reduced[best] < -TOLERANCE:
        return best
    for tie in np.flatnonzero(reduced <= TOLERANCE):
        # the tied column's entry grows; the first entry that changes decides
        direction = inverse @ A[:, tie]
        changed = np.abs(direction) > TOLERANCE
        first = np.argmin(np.where(changed, members, A.shape[1]))
        if changed[first] and members[first] < tie and direction[first] > 0.0:
            return int(tie)
    return None


def _leaving(direction: Array, x: Array, inverse: Array) -> int:
    """Return the row of the basis that reaches zero first, when b is changed a little."""
    rows = np.flatnonzero(direction > TOLERANCE)
    if not rows.size:
        raise UnboundedError("simplex: the cost has no least value")
    ratios = np.column_stack([x, inverse])[rows] / direction[rows, None]
    return int(rows[_lexicographic_least(ratios)])


def _lexicographic_least(rows: Array) -> int:
    left = np.arange(len(rows))
    for entry in range(rows.shape[1]):
        if len(left) == 1:
            break
        values = rows[left, entry]
        left = left[values <= values.min() + _TIE * max(1.0, abs(values.min()))]
    return int(left[0])
