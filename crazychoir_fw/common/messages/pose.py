"""Where a drone is and how it moves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.attitude import rotation_of_quaternion


@dataclass
class Pose:
    """Pose and twist of one drone, or of several; what is not known is None."""

    position: NDArray[np.float64] | None = None
    """Position (m, world), shape (..., 3)."""
    orientation: NDArray[np.float64] | None = None
    """Attitude, body to world, quaternion (x, y, z, w), shape (..., 4)."""
    velocity: NDArray[np.float64] | None = None
    """Velocity (m/s, world), shape (..., 3)."""
    angular: NDArray[np.float64] | None = None
    """Angular velocity (rad/s, body), shape (..., 3)."""
    time: float | None = None
    """When that was so (s), by the clock that everybody uses: simulated time in simulation."""

    @property
    def rotation(self) -> NDArray[np.float64]:
        """Attitude as matrices from body to world, shape (..., 3, 3); made once, for all laws that want it."""
        quat = np.asarray(self.orientation, float)
        # whoever fills a pose may write into its arrays; bytes are compared faster than numbers
        found = quat.shape, quat.tobytes()
        made_of, matrices = self.__dict__.get("_rotation", (None, None))
        if made_of != found:
            matrices = rotation_of_quaternion(quat)
            self.__dict__["_rotation"] = found, matrices
        return matrices
