"""Steps with poses: what a node does where simulated poses come as often as it works."""

from __future__ import annotations

import math

CLOSE = 1.5
"""Periods between poses, for which each pose makes a step."""


class PoseTriggered:
    """A node that works with each pose where simulated poses come often enough, else with its clock.

    Then results do not depend on which of pose and clock comes first.
    """

    _longest_step: float
    """Time between poses up to which they lead (s); whoever derives from this sets it."""
    _pose_time, _pose_step = -math.inf, math.inf  # [s], of the newest pose, and since the one before

    def _is_new_pose(self, time: float | None) -> bool:
        """Note the time of a pose (s); tell whether it is another one than before."""
        if time is None or time == self._pose_time:
            return False
        self._pose_step, self._pose_time = time - self._pose_time, time
        return True

    def _is_led_by_poses(self, now: float) -> bool:
        """Tell whether poses come so often, up to now, that each of them makes a step."""
        longest = self._longest_step
        return 0.0 < self._pose_step <= longest and now - self._pose_time <= longest

    def _forget_poses(self) -> None:
        """Begin anew."""
        self._pose_time, self._pose_step = -math.inf, math.inf
