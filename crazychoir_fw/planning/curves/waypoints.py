"""Waypoints that curves go through, checked."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError

Array = NDArray[np.float64]


def checked_points(who: str, points: ArrayLike) -> Array:
    """Return points as a new array (m, axes).

    Raises:
        RangeError: If there are fewer than two, or they are not finite.
    """
    q = np.array(points, dtype=float)
    if q.ndim != 2 or len(q) < 2:
        raise RangeError(f"{who}: points have shape {q.shape}, allowed: (m, axes) with at least 2 points")
    if not np.isfinite(q).all():
        raise RangeError(f"{who}: point {_first(~np.isfinite(q).all(axis=1))} is not finite")
    return q


def checked_waypoints(who: str, times: ArrayLike, points: ArrayLike) -> tuple[Array, Array]:
    """Return times and points as new arrays (m,) and (m, axes).

    Raises:
        RangeError: If there are fewer than two, times do not increase, or numbers are not finite.
    """
    t, q = np.array(times, dtype=float), checked_points(who, points)
    if t.shape != q.shape[:1]:
        raise RangeError(f"{who}: {t.size} times for {len(q)} points")
    if not np.isfinite(t).all():
        raise RangeError(f"{who}: time {_first(~np.isfinite(t))} is not finite")
    if np.diff(t).min() <= 0.0:
        k = _first(np.diff(t) <= 0.0)
        raise RangeError(f"{who}: times must increase, but {t[k + 1]:g} s comes after {t[k]:g} s (point {k + 1})")
    return t, q


def _first(mask: NDArray[np.bool_]) -> int:
    return int(np.argmax(mask))
