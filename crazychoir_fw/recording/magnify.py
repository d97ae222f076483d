"""Drones of a wide swarm, drawn larger than they are, so that a film shows them."""

from copy import copy

import mujoco
import numpy as np
from numpy.typing import NDArray

_WANTED = 0.11  # of the height of a picture, for a drone
_SPAN_M = 0.13  # of a drone, over its propellers
_MOST = 3.0
_CLOSEST = 0.75  # of the distance between two drones, how much their drawings may fill
_FOOT_M = 0.0145  # of the body over the floor, when it stands


def magnified(
    model: mujoco.MjModel,
    bodies: NDArray[np.int32],
    positions: NDArray[np.float64],
    distance: NDArray[np.float64],
) -> tuple[mujoco.MjModel, float]:
    """Return a model whose drones are drawn larger, and how many times; the model itself where they are large enough.

    Args:
        model: The world.
        bodies: Its drones.
        positions: Where they are (m, world), shape (F, N, 3).
        distance: Of the camera (m), shape (F,).
    """
    half = np.tan(np.radians(model.vis.global_.fovy) / 2.0)
    share = _SPAN_M / (2.0 * half * float(np.median(distance)))
    scale = float(np.clip(min(_WANTED / share, _CLOSEST * _closest(positions) / _SPAN_M), 1.0, _MOST))
    if scale < 1.05:
        return model, 1.0
    model = copy(model)
    done = set()
    for geom in np.flatnonzero(np.isin(model.geom_bodyid, bodies)):
        if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_MESH:
            continue
        # feet stay on the floor
        model.geom_pos[geom] = scale * model.geom_pos[geom] + [0.0, 0.0, (scale - 1.0) * _FOOT_M]
        mesh = int(model.geom_dataid[geom])
        if mesh not in done:
            done.add(mesh)
            begin = model.mesh_vertadr[mesh]
            model.mesh_vert[begin : begin + model.mesh_vertnum[mesh]] *= scale
        model.geom_rbound[geom] *= scale
    return model, scale


def _closest(positions: NDArray[np.float64]) -> float:
    """Return how near drones come to each other, but for the nearest twentieth of the time (m)."""
    if positions.shape[1] < 2:
        return np.inf
    nearest = []
    # 50 instants are enough for a quantile
    for points in positions[:: max(1, len(positions) // 50)]:
        gaps = np.linalg.norm(points[:, None] - points, axis=-1)
        np.fill_diagonal(gaps, np.inf)
        nearest.append(gaps.min())
    return float(np.quantile(nearest, 0.05))
