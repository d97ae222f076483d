"""Where a drone should be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True)
class Reference:
    """What a controller follows; what nobody asks for is None."""

    position: NDArray[np.float64] | None = None
    """Position (m, world), shape (..., 3)."""
    velocity: NDArray[np.float64] | None = None
    """Velocity (m/s, world), shape (..., 3)."""
    acceleration: NDArray[np.float64] | None = None
    """Acceleration without gravity (m/s^2, world), shape (..., 3)."""
    jerk: NDArray[np.float64] | None = None
    """Jerk (m/s^3, world), shape (..., 3)."""
    yaw: ArrayLike | None = None
    """Heading (rad), shape (...)."""
    yaw_rate: ArrayLike | None = None
    """Rate of the heading (rad/s), shape (...)."""
