"""What several comparisons do with signals: shifting, smoothing, alignment, root mean squares, quaternions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def rms(values: Array) -> float:
    """Return the root mean square; of rows of vectors, that of their lengths. NaN for nothing."""
    if values.size == 0:
        return float("nan")
    squares = values**2 if values.ndim == 1 else np.sum(values**2, axis=-1)
    return float(np.sqrt(np.mean(squares)))


def at(times: NDArray[Any], time: NDArray[Any], values: NDArray[Any]) -> Array:
    """Return columns of a signal at other times, the ends held; shape (len(times), ...)."""
    if values.ndim == 1:
        return np.interp(times, time, values)
    return np.stack([np.interp(times, time, column) for column in values.T], axis=1)


def shifted(time: Array, values: Array, lag: float) -> Array:
    """Return a signal that arrived `lag` seconds late at the times when it was made."""
    return at(time + lag, time, values)


def local_polynomial(values: Array, period: float, rows: int = 11, order: int = 3, derivative: int = 0) -> Array:
    """Return values or derivatives of polynomials fitted to the rows around each row (Savitzky and Golay).

    Args:
        values: Shape (T,) or (T, n).
        period: Time between rows (s).
        rows: Odd number of rows in each fit.
        order: Order of the polynomials.
        derivative: 0, 1 or 2.
    """
    half = rows // 2
    offsets = np.arange(-half, half + 1) * period
    weights = np.linalg.pinv(np.vander(offsets, order + 1, increasing=True))
    table = values if values.ndim == 2 else values[:, None]
    # at both ends the line through the last rows goes on
    slope_start, slope_end = table[1] - table[0], table[-1] - table[-2]
    steps = np.arange(1, half + 1)[:, None]
    padded = np.concatenate([table[0] - steps[::-1] * slope_start, table, table[-1] + steps * slope_end])
    kernel = weights[derivative] * (1.0, 1.0, 2.0)[derivative]
    result = np.stack([np.convolve(column, kernel[::-1], "valid") for column in padded.T], axis=1)
    return result if values.ndim == 2 else result[:, 0]


def smooth(values: Array, width: int) -> Array:
    """Return values smoothed by a Gaussian bell of a standard deviation in rows, without delay."""
    offsets = np.arange(-3 * width, 3 * width + 1)
    kernel = np.exp(-0.5 * (offsets / width) ** 2)
    kernel /= kernel.sum()
    table = values if values.ndim == 2 else values[:, None]
    padded = np.pad(table, ((3 * width, 3 * width), (0, 0)), mode="edge")
    result = np.stack([np.convolve(column, kernel, "valid") for column in padded.T], axis=1)
    return result if values.ndim == 2 else result[:, 0]


def least(cost: Callable[[float], float], low: float, high: float, step: float) -> float:
    """Return where a cost is least: the best of a grid, then of a parabola through its neighbors."""
    grid = np.arange(low, high + step / 2, step)
    costs = np.array([cost(float(x)) for x in grid])
    i = int(np.argmin(costs))
    if 0 < i < len(grid) - 1:
        left, here, right = costs[i - 1 : i + 2]
        bend = left - 2 * here + right
        if bend > 0.0:
            return float(grid[i] + 0.5 * step * (left - right) / bend)
    return float(grid[i])


def lag_of(late: Array, early: Array, time: Array, where: NDArray[np.bool_], most: float = 0.2) -> float:
    """Return by how much one signal comes after another (s), where both show the same.

    Args:
        late: Shape (T,) or (T, n).
        early: The same.
        time: Their common clock (s), shape (T,).
        where: Rows to look at, shape (T,).
        most: Greatest lag to look for in both directions (s).
    """
    limit = 3.0 * np.std(early[where]) + 1e-12

    def cost(lag: float) -> float:
        # clipped, so that single spikes do not decide
        return float(np.mean(np.clip((shifted(time, late, lag) - early)[where], -limit, limit) ** 2))

    return least(cost, -most, most, 0.005)


# ------------------------------------------------------------------------------- quaternions (xyzw)


def multiply(a: Array, b: Array) -> Array:
    """Return the products of two rows of quaternions (x, y, z, w)."""
    ax, ay, az, aw = a.T
    bx, by, bz, bw = b.T
    return np.stack(
        [
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ],
        axis=1,
    )


def conjugate(quaternion: Array) -> Array:
    """Return the inverse rotations."""
    return quaternion * np.array([-1.0, -1.0, -1.0, 1.0])


def turn(vector: Array) -> Array:
    """Return the quaternions of rotation vectors (rad), shape (n, 4)."""
    angle = np.linalg.norm(vector, axis=1, keepdims=True)
    half = np.where(angle > 1e-9, np.sin(angle / 2) / np.maximum(angle, 1e-9), 0.5)
    return np.concatenate([vector * half, np.cos(angle / 2)], axis=1)


def matrices(quaternion: Array) -> Array:
    """Return rotation matrices, body to world, shape (n, 3, 3)."""
    x, y, z, w = quaternion.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def tilt_between(a: Array, b: Array) -> Array:
    """Return the angles between the z axes of two rows of attitudes (deg)."""
    cosine = np.sum(matrices(a)[:, :, 2] * matrices(b)[:, :, 2], axis=1)
    return np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))


def roll_pitch_yaw(quaternion: Array) -> Array:
    """Return roll, pitch and yaw (deg, right-handed), shape (n, 3)."""
    r = matrices(quaternion)
    roll = np.arctan2(r[:, 2, 1], r[:, 2, 2])
    pitch = -np.arcsin(np.clip(r[:, 2, 0], -1.0, 1.0))
    yaw = np.arctan2(r[:, 1, 0], r[:, 0, 0])
    return np.degrees(np.stack([roll, pitch, yaw], axis=1))
