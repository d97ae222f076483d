"""Vectors by their components: floats for one drone, arrays for many, so that each law is written once.

Plain floats make a law some ten times faster for one drone than arrays of one number would.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Component = Any
"""A float, or an array of shape (...)."""

_TINY = 1e-300  # keeps a quaternion of zeros, which nobody has written yet, from dividing by zero: it is level


def split(array: Array) -> Sequence[Component]:
    """Return the components along the last axis."""
    return array.tolist() if array.ndim == 1 else [array[..., i] for i in range(array.shape[-1])]


def join(components: Sequence[Component], shape: tuple[int, ...]) -> Array:
    """Return components of shape `shape` (or of what can be broadcast to it) as one array, (*shape, len)."""
    if not shape:
        return np.array(components)
    array = np.empty((*shape, len(components)))
    for i, component in enumerate(components):
        array[..., i] = component
    return array


def sqrt(value: Component) -> Component:
    """Return the square root."""
    return math.sqrt(value) if isinstance(value, float) else np.sqrt(value)


def larger(value: Component, other: Component) -> Component:
    """Return the larger one, each by each."""
    if isinstance(value, float) and isinstance(other, float):
        return value if value > other else other
    return np.maximum(value, other)


def smaller(value: Component, other: Component) -> Component:
    """Return the smaller one, each by each."""
    if isinstance(value, float) and isinstance(other, float):
        return value if value < other else other
    return np.minimum(value, other)


def cosine_and_sine(angle: Component) -> tuple[Component, Component]:
    """Return both of an angle (rad)."""
    return (math.cos(angle), math.sin(angle)) if isinstance(angle, float) else (np.cos(angle), np.sin(angle))


def scalar(value: Any) -> Component:
    """Return a number, or numbers of shape (...), as a component."""
    return float(value) if np.ndim(value) == 0 else np.asarray(value, float)


def up_axis(quat_xyzw: Array) -> tuple[Component, Component, Component]:
    """Return where body z points in the world, of quaternions of any length, shape (..., 4)."""
    x, y, z, w = split(quat_xyzw)
    xx_yy = x * x + y * y
    s = 2.0 / (xx_yy + z * z + w * w + _TINY)
    return s * (x * z + w * y), s * (y * z - w * x), 1.0 - s * xx_yy


def rotation_rows(quat_xyzw: Array) -> tuple[Component, ...]:
    """Return the nine entries of the matrix from body to world, row by row, of quaternions of any length."""
    x, y, z, w = split(quat_xyzw)
    xx, yy, zz = x * x, y * y, z * z
    s = 2.0 / (xx + yy + zz + w * w + _TINY)
    sx, sy, sz = s * x, s * y, s * z
    xy, xz, yz, wx, wy, wz = sx * y, sx * z, sy * z, sx * w, sy * w, sz * w
    xx, yy, zz = s * xx, s * yy, s * zz
    return 1.0 - (yy + zz), xy - wz, xz + wy, xy + wz, 1.0 - (xx + zz), yz - wx, xz - wy, yz + wx, 1.0 - (xx + yy)
