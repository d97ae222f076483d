"""A motion without jumps through poses that come now and then, with gaps and noise."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.messages import Pose

Array = NDArray[np.float64]

_IDENTITY = np.array([0.0, 0.0, 0.0, 1.0])


class SmoothPath:
    """Goes on with the velocity of the last pose, and makes up for what a new one says otherwise little by little.

    Without new poses the motion comes to rest after a while, where it is.
    """

    def __init__(self, time_constant: float = 0.05, longest: float = 0.2, largest_jump: float = 0.5) -> None:
        """Choose how smooth.

        Args:
            time_constant: Within which a deviation fades away (s).
            longest: How long the motion goes on without a new pose (s).
            largest_jump: What is farther away than this is gone to at once (m).
        """
        self._time_constant, self._longest, self._largest_jump = time_constant, longest, largest_jump
        self._seen: Pose | None = None
        self._since = 0.0
        self._offset = np.zeros(3)
        self._turned_from = _IDENTITY

    @property
    def has_begun(self) -> bool:
        """Whether there was a pose."""
        return self._seen is not None

    def see(self, pose: Pose, now: float) -> None:
        """Take a new pose, with its velocity, at a time (s)."""
        position = np.array(pose.position, float)
        orientation = _IDENTITY if pose.orientation is None else np.array(pose.orientation, float)
        before = self.at(now) if self.has_begun else None
        self._offset, self._turned_from = np.zeros(3), orientation
        if before is not None and np.linalg.norm(before.position - position) <= self._largest_jump:
            self._offset, self._turned_from = before.position - position, before.orientation
        velocity = np.zeros(3) if pose.velocity is None else np.nan_to_num(pose.velocity)
        angular = np.zeros(3) if pose.angular is None else np.nan_to_num(pose.angular)
        self._seen, self._since = Pose(position, orientation, velocity, angular, now), now

    def at(self, now: float) -> Pose:
        """Return pose and velocity at a time (s) after the last pose that was seen.

        The velocity is the slope of the position. The attitude turns towards the one that was seen.
        """
        seen = self._seen
        assert seen is not None, "no pose was seen yet"
        age = max(0.0, now - self._since)
        fade = math.exp(-age / self._time_constant)
        goes_on = age < self._longest
        position = seen.position + min(age, self._longest) * seen.velocity + fade * self._offset
        velocity = goes_on * seen.velocity - fade / self._time_constant * self._offset
        orientation = _between(seen.orientation, self._turned_from, fade)
        return Pose(position, orientation, velocity, goes_on * seen.angular, now)


def _between(a: Array, b: Array, share: float) -> Array:
    """Return the attitude with a share of b, the rest of a: quaternions (4,), near each other."""
    mixed = (1.0 - share) * a + (share if float(a @ b) >= 0.0 else -share) * b
    length = float(np.linalg.norm(mixed))
    return mixed / length if length > 1e-9 else a
