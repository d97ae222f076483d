"""Rows of numbers that become more and more, such as the samples of a flight."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import DTypeLike, NDArray

_PIECE_BYTES = 1 << 22  # NumPy asks for large pages from here on, in which memory that is new costs far less
_MAX_ROWS = 1024  # short rows need no piece of that size


class GrowingBlock:
    """Rows of one shape and type, in pieces of memory that stay where they are while it grows."""

    def __init__(self, shape: tuple[int, ...], dtype: DTypeLike = np.float64) -> None:
        """Begin without a row.

        Args:
            shape: Of a row.
            dtype: Of its numbers.
        """
        self._shape = shape
        self._dtype = np.dtype(dtype)
        row_bytes = max(1, math.prod(shape) * self._dtype.itemsize)
        self._rows_per_piece = min(-(-_PIECE_BYTES // row_bytes), _MAX_ROWS)
        self._pieces: list[NDArray] = []
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def add(self) -> NDArray:
        """Return another row, to be filled."""
        place = self._count % self._rows_per_piece
        if place == 0:
            self._pieces.append(np.empty((self._rows_per_piece, *self._shape), self._dtype))
        self._count += 1
        return self._pieces[-1][place]

    def rows(self) -> NDArray:
        """Return a copy of all rows, shape (rows, ...)."""
        if not self._pieces:
            return np.empty((0, *self._shape), self._dtype)
        *full, last = self._pieces
        return np.concatenate([*full, last[: self._count - len(full) * self._rows_per_piece]])
