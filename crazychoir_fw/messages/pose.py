"""Where a drone is and how it moves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.attitude import rotation_of_quaternion


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
        made_of, matrices = self.__dict__.get("_rotation", (None, None))
        # whoever fills a pose may write into its arrays
        if made_of is None or made_of.shape != np.shape(self.orientation) or not (made_of == self.orientation).all():
            made_of = np.array(self.orientation, float)
            matrices = rotation_of_quaternion(made_of)
            self.__dict__["_rotation"] = made_of, matrices
        return matrices
