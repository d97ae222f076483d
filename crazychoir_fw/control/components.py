"""Vectors by their components: floats for one drone, arrays for many, so that each law is written once.

Plain floats make a law some ten times faster for one drone than arrays of one number would.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.attitude import rpy_of_rotation

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


def up_axis(quat_xyzw: Array) -> Sequence[Component]:
    """Return where body z points in the world, of quaternions of any length, shape (..., 4)."""
    if quat_xyzw.ndim > 1:
        return _of_products(quat_xyzw, _UP_AXIS)  # type: ignore[return-value]
    x, y, z, w = quat_xyzw.tolist()
    s = 2.0 / (x * x + y * y + z * z + w * w + _TINY)
    return s * (x * z + w * y), s * (y * z - w * x), 1.0 - s * (x * x + y * y)


def rotation(quat_xyzw: Array) -> Array:
    """Return the matrix from body to world, shape (..., 3, 3), of quaternions of any length, shape (..., 4)."""
    if quat_xyzw.ndim > 1:
        entries = _of_products(quat_xyzw, _ROTATION).reshape(3, 3, *quat_xyzw.shape[:-1])
        return entries.transpose(*range(2, entries.ndim), 0, 1)
    x, y, z, w = quat_xyzw.tolist()
    s = 2.0 / (x * x + y * y + z * z + w * w + _TINY)
    xx, yy, zz = s * x * x, s * y * y, s * z * z
    xy, xz, yz, wx, wy, wz = s * x * y, s * x * z, s * y * z, s * w * x, s * w * y, s * w * z
    return np.array(
        (
            (1.0 - yy - zz, xy - wz, xz + wy),
            (xy + wz, 1.0 - xx - zz, yz - wx),
            (xz - wy, yz + wx, 1.0 - xx - yy),
        )
    )


def _product_table() -> Array:
    """Return what makes nine entries and the squared length of the sixteen products xx, xy, ..., ww: (10, 16)."""
    table = np.zeros((4, 4, 10))
    x, y, z, w = range(4)
    for i, (first, second, third) in enumerate(((x, y, z), (y, z, x), (z, x, y))):
        table[[w, first, second, third], [w, first, second, third], 4 * i] = 1.0, 1.0, -1.0, -1.0
        # entries (i, j) and (j, i), with j the axis that follows
        j = second
        table[first, second, [3 * i + j, 3 * j + i]] = 2.0
        table[w, third, 3 * i + j], table[w, third, 3 * j + i] = -2.0, 2.0
    table[range(4), range(4), 9] = 1.0
    return np.ascontiguousarray(table.reshape(16, 10).T)


_ROTATION = _product_table()
_UP_AXIS = _ROTATION[[2, 5, 8, 9]]


def _of_products(quat_xyzw: Array, table: Array) -> Array:
    """Return what a table makes of a batch of quaternions, the entries first; one product of matrices does it all."""
    # drones along the last axis, in memory as well: NumPy's inner loops are long then
    q = np.ascontiguousarray(quat_xyzw.reshape(-1, 4).T)
    products = (q[:, None] * q).reshape(16, -1)
    products[15] += _TINY
    sums = table @ products
    return (sums[:-1] / sums[-1]).reshape(-1, *quat_xyzw.shape[:-1])


def roll_pitch_yaw(R: Array) -> Array:
    """Return roll, pitch and yaw (rad), shape (..., 3), of matrices from body to world, shape (..., 3, 3)."""
    if R.ndim > 2:
        return rpy_of_rotation(R)
    r00, _, _, r10, _, _, r20, r21, r22 = R.ravel().tolist()
    return np.array((math.atan2(r21, r22), -math.asin(min(max(r20, -1.0), 1.0)), math.atan2(r10, r00)))
