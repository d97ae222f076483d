"""What a controller asks of a drone, as on the topic ``cmd_vel``."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Twist:
    """Two vectors, whose meaning depends on the sender (docs/reference/crazychoir.md#2.2).

    FPQR: thrust (N) in linear z, body rates (rad/s) in angular. FRPY: thrust (N) in linear z, roll, pitch, yaw (rad) in
    angular. Vel: velocity (m/s, world) in linear, yaw rate (rad/s) in angular z.
    """

    linear: NDArray[np.float64]
    """Shape (..., 3)."""
    angular: NDArray[np.float64]
    """Shape (..., 3)."""
