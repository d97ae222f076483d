"""Attitudes as roll, pitch and yaw (rad, extrinsic x-y-z), for any number of them at once.

Right-handed: positive pitch lowers the nose. Arrays have shape (..., 3).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_MIN_COSINE = 1e-6  # of the pitch: Euler angles have no rates when the nose points straight up
_TINY = 1e-300  # keeps a quaternion of zeros from dividing by zero

Array = NDArray[np.float64]


def wrapped(angles: Array) -> Array:
    """Return angles in [-pi, pi) (rad)."""
    return (angles + np.pi) % (2.0 * np.pi) - np.pi


def rotation(rpy: Array) -> Array:
    """Return the matrix from body to world, shape (..., 3, 3)."""
    (sr, sp, sy), (cr, cp, cy) = np.sin(rpy).T, np.cos(rpy).T
    # filled in the order of the transpose, so that one line serves one drone and many
    R = np.empty((3, 3, *rpy.shape[-2::-1]))
    R[0, 0], R[0, 1], R[0, 2] = cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr
    R[1, 0], R[1, 1], R[1, 2] = sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr
    R[2, 0], R[2, 1], R[2, 2] = -sp, cp * sr, cp * cr
    return np.swapaxes(R.T, -1, -2)


def quaternion_xyzw(rpy: Array) -> Array:
    """Return the quaternion from body to world, shape (..., 4)."""
    half = 0.5 * rpy
    (sr, sp, sy), (cr, cp, cy) = np.moveaxis(np.sin(half), -1, 0), np.moveaxis(np.cos(half), -1, 0)
    return np.stack(
        [
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
            cr * cp * cy + sr * sp * sy,
        ],
        axis=-1,
    )


def rotation_of_quaternion(quat_xyzw: Array) -> Array:
    """Return the matrix from body to world, shape (..., 3, 3), of quaternions of any length, shape (..., 4).

    A quaternion of zeros, as before the first write, is level.
    """
    if quat_xyzw.ndim == 1:
        return _of_one(*quat_xyzw.tolist())
    # drones along the last axis, in memory as well: NumPy's inner loops are long then
    q = np.ascontiguousarray(quat_xyzw.reshape(-1, 4).T)
    products = (q[:, None] * q).reshape(16, -1)
    products[15] += _TINY
    sums = _OF_PRODUCTS @ products
    return (sums[:9] / sums[9]).T.reshape(*quat_xyzw.shape[:-1], 3, 3)


def _of_one(x: float, y: float, z: float, w: float) -> Array:
    """Return the matrix of one quaternion: floats take a third of the time."""
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


_OF_PRODUCTS = _product_table()


def rpy_of_rotation(R: Array) -> Array:
    """Return roll, pitch and yaw (rad), shape (..., 3), of matrices from body to world, shape (..., 3, 3)."""
    pitch = -np.arcsin(np.clip(R[..., 2, 0], -1.0, 1.0))
    return np.stack([np.arctan2(R[..., 2, 1], R[..., 2, 2]), pitch, np.arctan2(R[..., 1, 0], R[..., 0, 0])], axis=-1)


def angle_rates(rpy: Array, rates: Array) -> Array:
    """Return the rates of roll, pitch and yaw (rad/s) that body rates (rad/s) make."""
    (sr, sp, _), (cr, cp, _) = np.sin(rpy).T, np.cos(rpy).T
    cp = np.where(np.abs(cp) < _MIN_COSINE, np.copysign(_MIN_COSINE, cp), cp)
    p, q, r = rates.T
    turn = (sr * q + cr * r) / cp
    return np.array([p + turn * sp, cr * q - sr * r, turn]).T


def legacy_rates(rpy: Array, rates: Array) -> Array:
    """Return the body rates that the original integrator published for angle rates.

    docs/reference/crazychoir.md#4.4, #11.

    It inverts a matrix whose entry (2, 3) is the negative sine of the pitch in place of the roll.
    """
    sr, cr = np.sin(rpy[..., 0]), np.cos(rpy[..., 0])
    sp, cp, tp = np.sin(rpy[..., 1]), np.cos(rpy[..., 1]), np.tan(rpy[..., 1])
    one, zero = np.ones_like(sr), np.zeros_like(sr)
    rows = [[one, sr * tp, cr * tp], [zero, cr, -sp], [zero, sr / cp, cr / cp]]
    matrix = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    return np.linalg.solve(matrix, rates[..., None])[..., 0]
