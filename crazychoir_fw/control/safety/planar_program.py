r"""The nearest point of the plane within half-planes and a square: an exact solver for many agents at once.

Minimize :math:`|u - u_{des}|^2` where :math:`A u \le b` and :math:`|u|_\infty \le u_{max}`. Half-planes are added one
by one: where the best point so far violates the next one, the new best point lies on its boundary, which leaves a
program of one variable in closed form (Seidel 1991; ``bindings/laws/planar_program.c``). One violated half-plane costs
one such step, two cost two.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.onboard.arrays import doubles, filled_by_core

Array = NDArray[np.float64]

TOLERANCE = 1e-9
"""How far a solution may be beyond a half-plane (units of u, where the square is smaller than 1; else relative to
it)."""


def nearest(desired: ArrayLike, A: ArrayLike, b: ArrayLike, limit: ArrayLike) -> tuple[Array, NDArray[np.bool_]]:
    """Solve one program per agent.

    Args:
        desired: Points, shape (N, 2).
        A: Normals of the half-planes, of any length, shape (N, M, 2); a row of zeros is no half-plane.
        b: Their right sides, shape (N, M); infinite where there is no half-plane.
        limit: Half of the square's side, one for all or one per agent, shape () or (N,).

    Returns:
        Nearest points, shape (N, 2), and whether there is one, shape (N,); where there is none the point is nan.
    """
    sides = np.ascontiguousarray(b, np.float64)
    agents, rows = sides.shape
    points, found = np.empty((agents, 2)), np.empty(agents, bool)
    lib.cf_nearest_points(
        agents,
        rows,
        doubles(desired, (agents, 2)),
        doubles(A, (agents, rows, 2)),
        doubles(sides, (agents, rows)),
        doubles(limit, (agents,)),
        ffi.new("cf_half_plane_t[]", max(rows, 1)),
        filled_by_core(points),
        ffi.from_buffer("uint8_t[]", found),
    )
    return points, found
