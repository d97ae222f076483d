"""Steps triggered by poses: for nodes whose simulated poses come about as often as they step."""

from __future__ import annotations

import math

CLOSE = 1.5
"""Longest interval of poses that trigger steps, in periods of the node."""


class PoseTriggered:
    """A node that steps with each pose where simulated poses come often enough, else with its clock.

    Then results do not depend on which of pose and clock comes first.
    """

    _longest_step: float
    """Longest interval of poses that trigger steps (s); set by the subclass."""
    _pose_time, _pose_step = -math.inf, math.inf  # [s], of the newest pose, and since the one before

    def _is_new_pose(self, time: float | None) -> bool:
        """Store the time of a pose (s); return whether it differs from the previous one."""
        if time is None or time == self._pose_time:
            return False
        self._pose_step, self._pose_time = time - self._pose_time, time
        return True

    def _is_led_by_poses(self, now: float) -> bool:
        """Return whether poses up to now come often enough to trigger steps."""
        longest = self._longest_step
        return 0.0 < self._pose_step <= longest and now - self._pose_time <= longest

    def _forget_poses(self) -> None:
        """Reset the times of poses."""
        self._pose_time, self._pose_step = -math.inf, math.inf
