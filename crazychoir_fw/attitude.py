"""Attitudes as roll, pitch and yaw (rad, extrinsic x-y-z), for any number of them at once.

Right-handed: positive pitch lowers the nose. Arrays have shape (..., 3).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_LEAST_COSINE = 1e-6  # of the pitch: Euler angles have no rates when the nose points straight up

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
    """Return the matrix from body to world, shape (..., 3, 3), of quaternions of any length, shape (..., 4)."""
    x, y, z, w = quat_xyzw.T
    s = 2.0 / (x * x + y * y + z * z + w * w)
    R = np.empty((3, 3, *quat_xyzw.shape[-2::-1]))
    R[0, 0], R[0, 1], R[0, 2] = 1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)
    R[1, 0], R[1, 1], R[1, 2] = s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)
    R[2, 0], R[2, 1], R[2, 2] = s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)
    return np.swapaxes(R.T, -1, -2)


def rpy_of_rotation(R: Array) -> Array:
    """Return roll, pitch and yaw (rad), shape (..., 3), of matrices from body to world, shape (..., 3, 3)."""
    pitch = -np.arcsin(np.clip(R[..., 2, 0], -1.0, 1.0))
    return np.stack([np.arctan2(R[..., 2, 1], R[..., 2, 2]), pitch, np.arctan2(R[..., 1, 0], R[..., 0, 0])], axis=-1)


def angle_rates(rpy: Array, rates: Array) -> Array:
    """Return the rates of roll, pitch and yaw (rad/s) that body rates (rad/s) make."""
    (sr, sp, _), (cr, cp, _) = np.sin(rpy).T, np.cos(rpy).T
    cp = np.where(np.abs(cp) < _LEAST_COSINE, np.copysign(_LEAST_COSINE, cp), cp)
    p, q, r = rates.T
    turn = (sr * q + cr * r) / cp
    return np.array([p + turn * sp, cr * q - sr * r, turn]).T


def legacy_rates(rpy: Array, rates: Array) -> Array:
    """Return the body rates that the original integrator published for angle rates (features dossier 4.4, 11).

    It inverts a matrix whose entry (2, 3) is the negative sine of the pitch in place of the roll.
    """
    sr, cr = np.sin(rpy[..., 0]), np.cos(rpy[..., 0])
    sp, cp, tp = np.sin(rpy[..., 1]), np.cos(rpy[..., 1]), np.tan(rpy[..., 1])
    one, zero = np.ones_like(sr), np.zeros_like(sr)
    rows = [[one, sr * tp, cr * tp], [zero, cr, -sp], [zero, sr / cp, cr / cp]]
    matrix = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    return np.linalg.solve(matrix, rates[..., None])[..., 0]
