"""What layers hand to each other: plain data of numpy arrays, which the ROS nodes turn into messages and back.

World frame: x, y level, z up. Body frame: x forward, y left, z up. Quaternions are (x, y, z, w), body to world. Arrays
may have leading dimensions, (..., 3), for several drones at once.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

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
    """When that was so (s), by the clock of all: simulated time in simulation."""

    @property
    def rotation(self) -> NDArray[np.float64]:
        """Attitude as matrices from body to world, shape (..., 3, 3); made once, for all laws that want it."""
        quat = np.asarray(self.orientation, float)
        # the arrays of a pose may be written to; bytes are compared faster than numbers
        found = quat.shape, quat.tobytes()
        made_of, matrices = self.__dict__.get("_rotation", (None, None))
        if made_of != found:
            matrices = rotation_of_quaternion(quat)
            self.__dict__["_rotation"] = found, matrices
        return matrices


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


@dataclass(frozen=True)
class Reference:
    """What a controller follows; what is not asked for is None."""

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


def _zeros() -> NDArray[np.float64]:
    return np.zeros(3)


@dataclass(frozen=True)
class TrajectoryPoint:
    """One point of the topic ``traj_params``: a single point is a go-to, several are a drawn trajectory."""

    time_s: float
    """Time from the begin (s)."""
    position: NDArray[np.float64]
    """Position (m, world), shape (3,)."""
    velocity: NDArray[np.float64] = field(default_factory=_zeros)
    """Velocity there (m/s, world), shape (3,)."""
    acceleration: NDArray[np.float64] = field(default_factory=_zeros)
    """Acceleration there (m/s^2, world), shape (3,)."""
    jerk: NDArray[np.float64] = field(default_factory=_zeros)
    """Jerk there (m/s^3, world), shape (3,)."""
