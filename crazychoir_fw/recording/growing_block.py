"""Rows of one shape and type in memory that grows without being copied."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

_PIECE_BYTES = 1 << 22  # NumPy asks for large pages from here on, in which memory that is new costs far less
_MAX_ROWS = 2048  # short rows need no piece of that size


class GrowingBlock:
    """Rows of one shape and type, in pieces of memory that stay where they are while it grows."""

    def __init__(self, shape: Sequence[int], dtype: DTypeLike = np.float64) -> None:
        """Begin without a row.

        Args:
            shape: Of a row.
            dtype: Of its numbers.
        """
        self.shape = tuple(shape)
        self.dtype = np.dtype(dtype)
        self.row_bytes = math.prod(self.shape) * self.dtype.itemsize
        self._rows_per_piece = min(-(-_PIECE_BYTES // max(1, self.row_bytes)), _MAX_ROWS)
        self._pieces: list[NDArray[Any]] = []
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def add(self) -> NDArray[Any]:
        """Return another row, to be filled."""
        row = self.free()[0, ...]
        self.grow(1)
        return row

    def free(self) -> NDArray[Any]:
        """Return rows behind the present ones, (rows, ...), at least one; `grow` makes them rows of the block."""
        piece, place = divmod(self._count, self._rows_per_piece)
        if piece == len(self._pieces):
            self._pieces.append(np.empty((self._rows_per_piece, *self.shape), self.dtype))
        return self._pieces[piece][place:]

    def grow(self, count: int) -> None:
        """Take over so many of the rows that `free` returned."""
        self._count += count

    def filled(self) -> list[NDArray[Any]]:
        """Return the rows where they are, (rows, ...) each."""
        each, pieces = self._rows_per_piece, -(-self._count // self._rows_per_piece)
        return [piece[: self._count - k * each] for k, piece in enumerate(self._pieces[:pieces])]

    def rows(self) -> NDArray[Any]:
        """Return a copy of all rows, shape (rows, ...)."""
        return np.concatenate([np.empty((0, *self.shape), self.dtype), *self.filled()])

    def clear(self) -> None:
        """Forget all rows; the memory is filled again, which costs a tenth of new memory."""
        self._count = 0
