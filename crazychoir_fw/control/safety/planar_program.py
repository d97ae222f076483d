r"""The nearest point of the plane within half-planes and a square: an exact solver for many agents at once.

Minimize :math:`|u - u_{des}|^2` where :math:`A u \le b` and :math:`|u|_\infty \le u_{max}`. Half-planes are added one
by
one: where the best point so far violates the next one, the new best point lies on its boundary, which leaves a program
of one variable (Seidel 1991).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TOLERANCE = 1e-9
"""How far a solution may be beyond a half-plane (units of u, where the square is smaller than 1; else relative to
it)."""

_PARALLEL = 1e-12
_SQUARE = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])


def nearest(desired: Array, A: Array, b: Array, limit: Array | float) -> tuple[Array, NDArray[np.bool_]]:
    """Solve one program per agent.

    Args:
        desired: Points, shape (N, 2).
        A: Normals of the half-planes, of any length, shape (N, M, 2); a row of zeros is no half-plane.
        b: Their right sides, shape (N, M); infinite where there is no half-plane.
        limit: Half of the square's side, one for all or one per agent, shape () or (N,).

    Returns:
        Nearest points, shape (N, 2), and whether there is one, shape (N,); where there is none the point is nan.
    """
    size = np.broadcast_to(np.asarray(limit, dtype=np.float64), desired.shape[:1])
    best = np.clip(desired, -size[:, None], size[:, None])
    # a row of zeros may ask for the impossible
    found = ~np.any(~A.any(axis=-1) & (b < 0.0), axis=1)
    normals, sides = _that_matter(A, b, size)
    slack = TOLERANCE * np.maximum(1.0, size)
    for row in range(sides.shape[1]):
        normal, side = normals[:, row], sides[:, row]
        beyond = normal[:, 0] * best[:, 0] + normal[:, 1] * best[:, 1] - side
        worse = np.flatnonzero(found & (beyond > 0.1 * slack))
        if worse.size:
            best[worse], found[worse] = _on_boundary(
                desired[worse], normals[worse, : row + 1], sides[worse, : row + 1], size[worse], slack[worse]
            )
    best[~found] = np.nan
    return best, found


def _that_matter(A: Array, b: Array, size: Array) -> tuple[Array, Array]:
    """Return half-planes that cut the square, normals of length 1, the tightest first."""
    with np.errstate(divide="ignore", invalid="ignore"):
        length = np.hypot(A[..., 0], A[..., 1])
        normals = A / length[..., None]
        sides = b / length
    # what no point of the square violates cannot matter, and so most neighbors do not; false for nan
    matters = (length > 0.0) & (sides < size[:, None] * (np.abs(normals[..., 0]) + np.abs(normals[..., 1])))
    normals = np.where(matters[..., None], normals, 0.0)
    sides = np.where(matters, sides, np.inf)
    used = int(matters.sum(axis=1).max(initial=0))
    order = np.argsort(sides, axis=1, kind="stable")[:, :used]
    return np.take_along_axis(normals, order[..., None], axis=1), np.take_along_axis(sides, order, axis=1)


def _on_boundary(
    desired: Array, normals: Array, sides: Array, size: Array, slack: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """Return the nearest point on the boundary of the last half-plane, within the others and the square."""
    normal = normals[:, -1]
    start = desired - (np.sum(normal * desired, axis=1) - sides[:, -1])[:, None] * normal
    along = np.stack([-normal[:, 1], normal[:, 0]], axis=1)
    others = np.concatenate([normals[:, :-1], np.broadcast_to(_SQUARE, (len(desired), 4, 2))], axis=1)
    limits = np.concatenate([sides[:, :-1], np.broadcast_to(size[:, None], (len(desired), 4))], axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = others[..., 0] * along[:, None, 0] + others[..., 1] * along[:, None, 1]
        room = limits - others[..., 0] * start[:, None, 0] - others[..., 1] * start[:, None, 1]
        at = room / slope
        low = np.where(slope < -_PARALLEL, at, -np.inf).max(axis=1)
        high = np.where(slope > _PARALLEL, at, np.inf).min(axis=1)
        outside = np.any((np.abs(slope) <= _PARALLEL) & (room < -slack[:, None]), axis=1)
        found = ~outside & (low <= high + slack)
        place = np.clip(0.0, low, np.maximum(low, high))
        return start + place[:, None] * along, found
