"""Arrays of NumPy as the core reads and writes them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw._core import ffi


def doubles(values: ArrayLike, shape: tuple[int, ...]) -> Any:
    """Return numbers for the core to read, broadcast to a shape: a pointer that keeps them alive.

    Raises:
        ValueError: If they have another shape.
    """
    array = np.asarray(values, np.float64)
    if array.shape != shape:
        array = np.broadcast_to(array, shape) if array.ndim else np.full(shape, array)
    return ffi.from_buffer("double[]", np.ascontiguousarray(array))


def filled_by_core(array: NDArray[np.float64]) -> Any:
    """Return an array in one piece for the core to write."""
    return ffi.from_buffer("double[]", array, require_writable=True)
