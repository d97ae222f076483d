"""Curves of least snap through waypoints.

Each piece has degree 7, so that position, velocity, acceleration and jerk at both of its ends determine it. What a
waypoint leaves open is found by one linear solve: the integral of squared snap is quadratic in those values, and its
matrix is a chain of 4 x 4 blocks (C. Richter, A. Bry, N. Roy, "Polynomial trajectory planning for aggressive quadrotor
flight in dense indoor environments", ISRR 2013).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.planning.curves.polynomial import Polynomial
from crazychoir_fw.planning.curves.waypoints import checked_waypoints

Array = NDArray[np.float64]

_ORDERS = np.array([0, 1, 2, 3] * 2)  # of the eight boundary values of a piece


def _unit_matrices() -> tuple[Array, Array]:
    """Return what makes coefficients of boundary values over [0, 1], and the cost of those values."""
    k = np.arange(8)
    boundary = np.zeros((8, 8))
    factor = np.ones(8)
    for order in range(4):
        boundary[order, order] = factor[order]
        boundary[4 + order] = factor
        factor = factor * np.maximum(k - order, 0)
    # factor is now k (k-1) (k-2) (k-3)
    powers = np.maximum(k[:, None] + k - 7, 1)
    coefficients = np.linalg.inv(boundary)
    return coefficients, coefficients.T @ (np.outer(factor, factor) / powers) @ coefficients


_COEFFICIENTS, _COST = _unit_matrices()


def minimum_snap(
    times: ArrayLike,
    points: ArrayLike,
    *,
    velocities: Sequence[ArrayLike | None] | None = None,
    start: Sequence[ArrayLike] = (),
    end: Sequence[ArrayLike] = (),
) -> Polynomial:
    """Return the curve through points whose integral of squared snap is least.

    Derivatives up to the sixth are continuous, except where a velocity is given: there up to the fifth of those that
    are not.

    Args:
        times: When each point is reached (s), increasing, shape (m,), m at least 2.
        points: Shape (m, axes).
        velocities: Velocity at each point (m/s, shape (axes,)), or None where it is free; of the first and last point
            too, if not named in `start` and `end`.
        start: Velocity, acceleration, jerk at the first point, as many as are known; the others are 0.
        end: The same at the last point.

    Raises:
        RangeError: If the waypoints make no curve.
    """
    t, q = checked_waypoints("minimum_snap", times, points)
    values, is_free = _boundary_values(q, velocities, start, end)
    durations = np.diff(t)
    _solve(durations, values, is_free)
    return _curve(durations, values)


def _boundary_values(q: Array, velocities: object, start: object, end: object) -> tuple[Array, NDArray[np.bool_]]:
    """Return position to jerk at each point, shape (m, 4, axes), and which of them are free, (m, 4)."""
    m, axes = q.shape
    values = np.zeros((m, 4, axes))
    is_free = np.ones((m, 4), dtype=bool)
    values[:, 0], is_free[:, 0] = q, False
    is_free[0] = is_free[-1] = False
    if velocities is not None:
        if len(velocities) != m:
            raise RangeError(f"minimum_snap: {len(velocities)} velocities for {m} points")
        for k, velocity in enumerate(velocities):
            if velocity is not None:
                values[k, 1], is_free[k, 1] = velocity, False
    for k, derivatives in ((0, start), (-1, end)):
        for order, value in enumerate(derivatives, start=1):
            values[k, order] = value
    if not np.isfinite(values).all():
        raise RangeError("minimum_snap: velocities and boundary values must be finite")
    return values, is_free


def piece_costs(durations: Array) -> Array:
    """Return the matrices by which boundary values of pieces cost snap, shape (n, 8, 8)."""
    scale = durations[:, None] ** (_ORDERS - 3.5)
    return scale[:, :, None] * _COST * scale[:, None, :]


def snap_gradient(curve: Polynomial) -> tuple[float, Array]:
    """Return the cost of a curve of least snap, and how it changes with each duration, shape (n,).

    Free boundary values need not be differentiated: at the optimum the cost does not change with them.
    """
    T = curve.durations
    begins, ends = (np.stack([_at_ends(curve, order)[side] for order in range(4)], axis=1) for side in (0, 1))
    x = np.concatenate([begins, ends], axis=1)
    costs = piece_costs(T)
    slopes = costs * (_ORDERS[:, None] + _ORDERS - 7) / T[:, None, None]
    cost = np.einsum("nia,nij,nja->", x, costs, x)
    return float(cost), np.einsum("nia,nij,nja->n", x, slopes, x)


def _at_ends(curve: Polynomial, order: int) -> tuple[Array, Array]:
    """Return a derivative at begin and end of each piece, shapes (n, axes)."""
    derived = curve.derived(order)
    powers = curve.durations[:, None] ** np.arange(derived.shape[2])
    return derived[:, :, 0], np.einsum("nak,nk->na", derived, powers)


def _solve(durations: Array, values: Array, is_free: NDArray[np.bool_]) -> None:
    """Fill the free ones of *values* such that the cost is least: elimination along the chain of blocks."""
    m, _, axes = values.shape
    # in units of the mean duration the blocks are well conditioned
    unit = float(durations.mean())
    scale = (unit ** np.arange(4))[:, None]
    costs = piece_costs(durations / unit)
    known = np.where(is_free[:, :, None], 0.0, values * scale)

    diagonal = np.zeros((m, 4, 4))
    diagonal[:-1] += costs[:, :4, :4]
    diagonal[1:] += costs[:, 4:, 4:]
    beside = costs[:, 4:, :4]  # row of the point behind, column of the one before
    right = -np.einsum("mij,mja->mia", diagonal, known)
    right[1:] -= np.einsum("mij,mja->mia", beside, known[:-1])
    right[:-1] -= np.einsum("mji,mja->mia", beside, known[1:])
    # known values are kept by rows of the identity
    both = is_free[:, :, None] & is_free[:, None, :]
    diagonal = np.where(both, diagonal, 0.0) + np.eye(4) * ~is_free[:, :, None]
    beside = np.where(is_free[1:, :, None] & is_free[:-1, None, :], beside, 0.0)
    right = np.where(is_free[:, :, None], right, 0.0)

    for k in range(1, m):
        gain = np.linalg.solve(diagonal[k - 1], beside[k - 1].T).T
        diagonal[k] -= gain @ beside[k - 1].T
        right[k] -= gain @ right[k - 1]
    found = np.zeros((m, 4, axes))
    found[-1] = np.linalg.solve(diagonal[-1], right[-1])
    for k in range(m - 2, -1, -1):
        found[k] = np.linalg.solve(diagonal[k], right[k] - beside[k].T @ found[k + 1])
    values[:] = np.where(is_free[:, :, None], found / scale, values)


def _curve(durations: Array, values: Array) -> Polynomial:
    # in time over [0, 1] a derivative grows by the duration, and coefficients shrink again
    ends = np.concatenate([values[:-1], values[1:]], axis=1) * (durations[:, None] ** _ORDERS)[:, :, None]
    unit = np.einsum("ij,nja->nai", _COEFFICIENTS, ends)
    return Polynomial(durations, unit / (durations[:, None] ** np.arange(8))[:, None, :])
