"""Poses: external ones, thinned out to a set rate, and the odometry of a drone by its own estimator."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from cflib.utils.encoding import decompress_quaternion
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.finite import LARGEST
from crazychoir_fw.radio.parameters import element_of


class PoseThrottle:
    """Lets so many samples per second through, whatever the rate and regularity of its source.

    Args:
        rate_hz: Samples per second on average, at most.

    Raises:
        RangeError: If it is not above 0.
    """

    def __init__(self, rate_hz: float) -> None:
        if not (math.isfinite(rate_hz) and rate_hz > 0.0):
            raise RangeError(f"pose_hz is {rate_hz!r}, allowed: a number above 0")
        self._period = 1.0 / rate_hz
        self._due = -math.inf

    def passes(self, now: float) -> bool:
        """Return whether a sample that comes now (s) is to be sent."""
        # a hair early counts: samples that come exactly at the rate would else lose every second one to rounding
        if now < self._due - 1e-3 * self._period:
            return False
        # on the grid of the last one, so that 100 samples per second become 30 and not 25; restarted after a gap
        late = now - self._due
        self._due = self._due + self._period if late < self._period else now + self._period
        return True


def usable_pose(
    position: Sequence[float], quat_xyzw: Sequence[float] | None
) -> tuple[tuple[float, ...], tuple[float, ...] | None] | None:
    """Return position (m) and normalized quaternion, or None for a sample without a body in it.

    Motion capture marks a body that it does not see by zeros or by numbers that are not finite.

    Raises:
        RangeError: If one has another shape.
    """
    point = np.asarray(position, float)
    if point.shape != (3,):
        raise RangeError(f"position is {position!r}, allowed: three numbers (m)")
    if not np.all(np.abs(point) <= LARGEST):  # false for what is no number
        return None
    if quat_xyzw is None:
        return tuple(point.tolist()), None
    quat = np.asarray(quat_xyzw, float)
    if quat.shape != (4,):
        raise RangeError(f"quat_xyzw is {quat_xyzw!r}, allowed: four numbers")
    norm = float(np.linalg.norm(quat))
    if not (math.isfinite(norm) and norm > 0.1):
        return None
    return tuple(point.tolist()), tuple((quat / norm).tolist())


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
