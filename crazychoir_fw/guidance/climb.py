"""Straight up or down at a steady speed, for guidance that asks for accelerations."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.messages import Pose

Array = NDArray[np.float64]


class Climb:
    """A vertical way that begins at a time and ends at a height."""

    def __init__(self, start: Array, height: float, begin: float, speed: float) -> None:
        """Set out.

        Args:
            start: Where the way begins (m, world), shape (3,).
            height: Where it ends (m); below the start it leads down.
            begin: When (s).
            speed: Of the climb or descent (m/s), above 0.
        """
        self.start = np.array(start, dtype=np.float64)
        self._rise = height - self.start[2]
        self._begin = begin
        self._speed = speed

    def wanted(self, now: float) -> tuple[Array, Array]:
        """Return where to be (m), shape (3,), and how fast (m/s), shape (3,), at a time (s)."""
        length = abs(self._rise)
        way = min(self._speed * (now - self._begin), length)
        place = self.start.copy()
        place[2] += math.copysign(way, self._rise)
        speed = math.copysign(self._speed, self._rise) if way < length else 0.0
        return place, np.array([0.0, 0.0, speed])


def toward(pose: Pose, place: Array, velocity: Array, k_p: float, k_d: float) -> Array:
    """Return the acceleration (m/s^2), shape (3,), of a double integrator that follows a place and its velocity."""
    own = np.zeros(3) if pose.velocity is None else pose.velocity
    return k_p * (place - pose.position) + k_d * (velocity - own)
