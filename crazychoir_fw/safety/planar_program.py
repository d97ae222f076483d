r"""The nearest point of the plane within half-planes and a square: an exact solver for many agents at once.

Minimize :math:`|u - u_{des}|^2` where :math:`A u \le b` and :math:`|u|_\infty \le u_{max}`. The optimum is the desired
point itself, its projection on one boundary, or where two boundaries cross: all of these are tried.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TOLERANCE = 1e-9
"""How far a solution may be beyond a half-plane (units of u), and beyond the square relative to its size."""

_SQUARE = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])


def nearest(desired: Array, A: Array, b: Array, limit: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Solve one program per agent.

    Args:
        desired: Points, shape (N, 2).
        A: Normals of the half-planes, of any length, shape (N, M, 2); a row of zeros is no half-plane.
        b: Their right sides, shape (N, M); infinite where there is no half-plane.
        limit: Half of the square's side, one for all or one per agent, shape () or (N,).

    Returns:
        Nearest points, shape (N, 2), and whether there is one, shape (N,); where there is none the point is nan.
    """
    size = np.broadcast_to(np.asarray(limit, dtype=np.float64), desired.shape[:1])[:, None]
    length = np.linalg.norm(A, axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        normals = A / length[..., None]
        sides = b / length
    # what no point of the square violates cannot matter, and so most neighbors do not
    reach = size * np.abs(normals).sum(axis=-1)
    matters = sides < reach  # false for nan
    used = int(matters.sum(axis=1).max(initial=0))
    if used:
        # those that matter first; the rest of the row is filled with half-planes that hold everything
        order = np.argsort(~matters, axis=1, kind="stable")[:, :used]
        kept = np.take_along_axis(matters, order, axis=1)
        normals = np.where(kept[..., None], np.take_along_axis(normals, order[..., None], axis=1), 0.0)
        sides = np.where(kept, np.take_along_axis(sides, order, axis=1), np.inf)
    else:
        normals, sides = normals[:, :0], sides[:, :0]
    normals = np.concatenate([normals, np.broadcast_to(_SQUARE, (len(desired), 4, 2))], axis=1)
    sides = np.concatenate([sides, np.broadcast_to(size, (len(desired), 4))], axis=1)
    points = _candidates(desired, normals, sides)
    return _best(desired, points, normals, sides, TOLERANCE * np.maximum(1.0, size))


def _candidates(desired: Array, normals: Array, sides: Array) -> Array:
    """Return the desired point, its projections on boundaries, and where boundaries cross, shape (N, K, 2)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        excess = np.einsum("nmk,nk->nm", normals, desired) - sides
        projections = desired[:, None] - excess[..., None] * normals
        first, second = np.triu_indices(normals.shape[1], 1)
        one, two = normals[:, first], normals[:, second]
        determinant = one[..., 0] * two[..., 1] - one[..., 1] * two[..., 0]
        s, t = sides[:, first], sides[:, second]
        crossings = np.stack([s * two[..., 1] - t * one[..., 1], t * one[..., 0] - s * two[..., 0]], axis=-1)
        crossings = crossings / determinant[..., None]
    return np.concatenate([desired[:, None], projections, crossings], axis=1)


def _best(desired: Array, points: Array, normals: Array, sides: Array, slack: Array) -> tuple[Array, NDArray[np.bool_]]:
    with np.errstate(invalid="ignore"):
        beyond = np.einsum("nmk,npk->npm", normals, points) - sides[:, None]
        # nan, of boundaries that do not cross, is no point
        allowed = np.all(beyond <= slack[..., None], axis=-1)
        distance = np.where(allowed, np.sum((points - desired[:, None]) ** 2, axis=-1), np.inf)
    chosen = np.argmin(distance, axis=1)
    found = np.isfinite(np.take_along_axis(distance, chosen[:, None], axis=1)[:, 0])
    best = np.take_along_axis(points, chosen[:, None, None], axis=1)[:, 0]
    return np.where(found[:, None], best, np.nan), found
