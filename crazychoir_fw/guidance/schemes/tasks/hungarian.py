"""The best assignment, found with all costs in one place: the reference for distributed assignments."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def best_assignment(costs: ArrayLike) -> dict[int, int]:
    """Return column by row: as many as possible, and among those the least sum of costs.

    The Hungarian method by shortest augmenting paths (Kuhn 1955, Jonker and Volgenant 1987), in time O(n^3).

    Args:
        costs: Cost of each row with each column, shape (rows, columns); infinite where they do not go together.
    """
    given = np.array(costs, float)
    if given.size == 0:
        return {}
    size = max(given.shape)
    possible = np.isfinite(given)
    largest = float(np.abs(given[possible]).max()) if possible.any() else 0.0
    # dearer than any number of good ones
    square = np.full((size, size), 2.0 * (largest + 1.0) * size)
    square[: given.shape[0], : given.shape[1]] = np.where(possible, given, square[0, 0])
    matched = _perfect_matching(square)
    return {row: column for row, column in enumerate(matched[: len(given)]) if _is_in(possible, row, column)}


def _is_in(possible: np.ndarray, row: int, column: int) -> bool:
    return column < possible.shape[1] and bool(possible[row, column])


def _perfect_matching(costs: np.ndarray) -> list[int]:
    """Return the column of each row of a square matrix."""
    size = len(costs)
    row_price, column_price = np.zeros(size), np.zeros(size + 1)
    row_of = np.full(size + 1, -1)  # the last column stands for none
    for row in range(size):
        row_of[size], column = row, size
        slack, came_from = np.full(size, np.inf), np.full(size, size)
        done = np.zeros(size + 1, bool)
        while row_of[column] >= 0:
            done[column] = True
            open_ = np.flatnonzero(~done[:size])
            reduced = costs[row_of[column], open_] - row_price[row_of[column]] - column_price[open_]
            better = open_[reduced < slack[open_]]
            came_from[better] = column
            slack[open_] = np.minimum(slack[open_], reduced)
            following = int(open_[np.argmin(slack[open_])])
            step = slack[following]
            row_price[row_of[done]] += step
            column_price[done] -= step
            slack[open_] -= step
            column = following
        while column != size:
            row_of[column] = row_of[came_from[column]]
            column = int(came_from[column])
    columns = [0] * size
    for column in range(size):
        columns[row_of[column]] = column
    return columns
