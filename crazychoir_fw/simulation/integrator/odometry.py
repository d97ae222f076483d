"""What an integrator tells of its drones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Odometry:
    """Pose and twist of one or many drones at an instant; `...` is () for one and (N,) for many."""

    time: float
    """Time (s)."""
    position: NDArray[np.float64]
    """Position (m, world), shape (..., 3)."""
    quat_xyzw: NDArray[np.float64]
    """Attitude, body to world, shape (..., 4)."""
    velocity: NDArray[np.float64]
    """Velocity (m/s, world), shape (..., 3)."""
    rates: NDArray[np.float64]
    """Angular velocity (rad/s, body), shape (..., 3)."""
