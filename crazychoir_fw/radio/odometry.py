"""Pose and motion of a drone by its own estimator, out of log variables."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from cflib.utils.encoding import decompress_quaternion
from numpy.typing import NDArray

from crazychoir_fw.radio.parameters import element_of

_THOUSAND = 1000.0

_NAMES = ("x", "y", "z", "vx", "vy", "vz", "quat", "rateRoll", "ratePitch", "rateYaw")
COMPRESSED = tuple(f"stateEstimateZ.{name}" for name in _NAMES)  # 22 bytes: one block
KALMAN = ("kalman.stateX", "kalman.stateY", "kalman.stateZ")


@dataclass(frozen=True)
class Odometry:
    """What a drone believes about its own pose and motion."""

    position: NDArray[np.float64]
    """Position (m, world), shape (3,)."""
    quat_xyzw: NDArray[np.float64]
    """Attitude, body to world, shape (4,); without rotation where the drone logs the position only."""
    velocity: NDArray[np.float64]
    """Velocity (m/s, world), shape (3,); zero where the drone logs the position only."""
    body_rates: NDArray[np.float64]
    """Angular velocity (rad/s, body, right-handed), shape (3,); zero where the drone logs the position only."""
    time_s: float
    """Time since the drone started (s), by its own clock."""
    received_s: float
    """Time of reception (s), by the clock of the handler."""


def odometry_reader(toc: object) -> tuple[tuple[str, ...], Callable[[Mapping[str, float], float, float], Odometry]]:
    """Return the variables of the best odometry that a drone can log in one block, and what makes a message of them."""
    has_all = all(element_of(toc, name) is not None for name in COMPRESSED)
    return (COMPRESSED, from_compressed) if has_all else (KALMAN, from_kalman)


def from_compressed(values: Mapping[str, float], time_s: float, received_s: float) -> Odometry:
    """Read the log group ``stateEstimateZ``: millimeters, milliradians per second, a quaternion in 32 bits."""
    x, y, z, vx, vy, vz, quat, roll, pitch, yaw = (values[name] for name in COMPRESSED)
    return Odometry(
        np.array([x, y, z]) / _THOUSAND,
        # before the estimator runs the drone logs zeros, which are no rotation but would be read as half a turn
        decompress_quaternion(int(quat)) if quat else np.array([0.0, 0.0, 0.0, 1.0]),
        np.array([vx, vy, vz]) / _THOUSAND,
        # the firmware's pitch rate is positive for a nose that rises
        np.array([roll, -pitch, yaw]) / _THOUSAND,
        time_s,
        received_s,
    )


def from_kalman(values: Mapping[str, float], time_s: float, received_s: float) -> Odometry:
    """Read the position of the Kalman filter."""
    position = np.array([values[name] for name in KALMAN], float)
    return Odometry(position, np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3), np.zeros(3), time_s, received_s)
