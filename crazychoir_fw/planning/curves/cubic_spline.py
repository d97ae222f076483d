"""Cubic splines with velocity and acceleration given at both ends (docs/reference/crazychoir.md#7.3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.planning.curves.polynomial import Polynomial
from crazychoir_fw.planning.curves.waypoints import checked_waypoints

Array = NDArray[np.float64]


def cubic_spline(
    times: ArrayLike,
    points: ArrayLike,
    *,
    start_velocity: ArrayLike = 0.0,
    start_acceleration: ArrayLike = 0.0,
    end_velocity: ArrayLike = 0.0,
    end_acceleration: ArrayLike = 0.0,
) -> Polynomial:
    """Return the cubic spline through points: position, velocity and acceleration are continuous.

    Four boundary values are two more than a cubic spline has room for, so the first and the last interval are halved
    by a free knot each. Two points alone get a knot between them, where the polynomial of degree 5 with the same
    boundary values is at half time: from rest to rest that is the middle.

    Args:
        times: When each point is reached (s), increasing, shape (m,), m at least 2. The curve begins at the first.
        points: Shape (m, axes).
        start_velocity: Velocity at the first point, shape (axes,) or a number; the other three alike.
        start_acceleration: Acceleration at the first point.
        end_velocity: Velocity at the last point.
        end_acceleration: Acceleration at the last point.

    Raises:
        RangeError: If there are fewer than two points, times do not increase, or numbers are not finite.
    """
    t, q = checked_waypoints("cubic_spline", times, points)
    v0, a0, v1, a1 = (
        np.broadcast_to(np.asarray(value, dtype=float), q.shape[1:])
        for value in (start_velocity, start_acceleration, end_velocity, end_acceleration)
    )
    if len(t) == 2:
        T = t[1] - t[0]
        middle = (q[0] + q[1]) / 2 + 5 * T / 32 * (v0 - v1) + T**2 / 64 * (a0 + a1)
        t, q = np.insert(t, 1, t[0] + T / 2), np.insert(q, 1, middle, axis=0)

    # the free knots halve the outer intervals; their points are found with the accelerations
    t = np.concatenate([t[:1], [(t[0] + t[1]) / 2], t[1:-1], [(t[-2] + t[-1]) / 2], t[-1:]])
    T = np.diff(t)
    q = np.concatenate([q[:1], q[:1], q[1:-1], q[-1:], q[-1:]])
    # what is known of the free points: q_1 = known + T_0^2 w_1 / 6, and the last but one alike
    q[1] += T[0] * v0 + T[0] ** 2 / 3 * a0
    q[-2] += -T[-1] * v1 + T[-1] ** 2 / 3 * a1

    w = _accelerations(T, q, a0, a1)
    q[1] += T[0] ** 2 / 6 * w[1]
    q[-2] += T[-1] ** 2 / 6 * w[-2]
    h = T[:, None]
    coefficients = [
        q[:-1],
        np.diff(q, axis=0) / h - h * (w[1:] + 2 * w[:-1]) / 6,
        w[:-1] / 2,
        np.diff(w, axis=0) / (6 * h),
    ]
    return Polynomial(T, np.stack(coefficients, axis=-1))


def _accelerations(T: Array, q: Array, a0: Array, a1: Array) -> Array:
    """Return the acceleration at every knot, shape (n + 1, axes), such that the velocity is continuous.

    At an inner knot T_{i-1} w_{i-1} + 2 (T_{i-1} + T_i) w_i + T_i w_{i+1} = 6 (change of slope there).
    """
    lower, upper = T[:-1].copy(), T[1:].copy()
    diagonal = 2 * (T[:-1] + T[1:])
    right = 6 * np.diff(np.diff(q, axis=0) / T[:, None], axis=0)
    right[0] -= T[0] * a0
    right[-1] -= T[-1] * a1
    # slopes beside the free knots contain their accelerations
    diagonal[0] += T[0] * (1 + T[0] / T[1])
    diagonal[-1] += T[-1] * (1 + T[-1] / T[-2])
    lower[1] -= T[0] ** 2 / T[1]
    upper[-2] -= T[-1] ** 2 / T[-2]

    # elimination without pivoting: the diagonal dominates
    for i in range(1, len(diagonal)):
        factor = lower[i] / diagonal[i - 1]
        diagonal[i] -= factor * upper[i - 1]
        right[i] -= factor * right[i - 1]
    w = np.empty((len(T) + 1, q.shape[1]))
    w[0], w[-1] = a0, a1
    w[-2] = right[-1] / diagonal[-1]
    for i in range(len(diagonal) - 2, -1, -1):
        w[i + 1] = (right[i] - upper[i] * w[i + 2]) / diagonal[i]
    return w
