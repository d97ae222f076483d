"""Age of the latest pose of a drone."""

from __future__ import annotations

from crazychoir_fw.common.messages import Pose
from crazychoir_fw.ros.node import LayerNode


class PoseWatch:
    """Tracks whether the latest pose is fresh; logs once when poses stop, and once when they resume.

    A pose is new if its stamp is: filters repeat the last good one while a drone is lost. Its age counts from when it
    came, since stamps may be those of another computer.
    """

    def __init__(self, node: LayerNode, timeout: float) -> None:
        """Set the age at which a pose is stale (s)."""
        self._node, self._timeout = node, timeout
        self.reset()

    def reset(self) -> None:
        """Forget all poses."""
        self._stamp: float | None = None
        self._came: float | None = None
        self._is_silent = False

    def saw(self, pose: Pose, now: float) -> None:
        """Store stamp and arrival time of a pose (s)."""
        if pose.time is None or pose.time != self._stamp:
            self._stamp, self._came = pose.time, now

    def is_fresh(self, now: float) -> bool:
        """Return whether the latest pose may be relied on at a time (s); False before the first one."""
        if self._came is None:
            return False
        is_old = now - self._came > self._timeout
        if is_old != self._is_silent:
            self._is_silent = is_old
            logger = self._node.get_logger()
            if is_old:
                logger.warning(
                    f"no pose for {now - self._came:.2f} s (pose_timeout {self._timeout:g} s): sends no more"
                )
            else:
                logger.info("poses again: goes on")
        return not is_old
