"""Distance from a convex hull."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def distance_from_hull(point: ArrayLike, corners: ArrayLike) -> float:
    """Return how far a point is from the convex hull of others (m); zero inside.

    Args:
        point: Shape (3,).
        corners: Shape (L, 3), any number of them, also in one plane or line.
    """
    return float(np.linalg.norm(_nearest(np.asarray(corners, np.float64) - np.asarray(point, np.float64))))


def _nearest(corners: Array) -> Array:
    """Return the point of a convex hull that is nearest to the origin, shape (3,) (Wolfe's algorithm)."""
    scale = max(1e-12, float(np.abs(corners).max()))
    points = corners / scale
    chosen = [int(np.argmin(np.einsum("ij,ij->i", points, points)))]
    weights = np.ones(1)
    for _ in range(100 * len(points)):
        nearest = weights @ points[chosen]
        ahead = int(np.argmin(points @ nearest))
        if ahead in chosen or nearest @ nearest - points[ahead] @ nearest < 1e-14:
            break
        chosen, weights = [*chosen, ahead], np.append(weights, 0.0)
        while True:
            flat = _flat_weights(points[chosen])
            if (flat > 1e-14).all():
                weights = flat
                break
            # as far towards the nearest point of the plane as the hull goes
            inward = flat <= 1e-14
            share = np.min(weights[inward] / np.maximum(weights[inward] - flat[inward], 1e-300))
            weights = weights + min(1.0, share) * (flat - weights)
            kept = weights > 1e-14
            chosen = [corner for corner, keep in zip(chosen, kept, strict=True) if keep]
            weights = weights[kept] / weights[kept].sum()
    return scale * (weights @ points[chosen])


def _flat_weights(points: Array) -> Array:
    """Return the weights, adding up to one, of the point nearest to the origin in the plane through some points."""
    count = len(points)
    system = np.ones((count + 1, count + 1))
    system[:count, :count] = points @ points.T
    system[count, count] = 0.0
    right = np.append(np.zeros(count), 1.0)
    return np.linalg.lstsq(system, right, rcond=None)[0][:count]
