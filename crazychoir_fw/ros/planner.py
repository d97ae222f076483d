"""`PointToPointPlanner_2D`: go-tos in the plane, one at a time (docs/reference/crazychoir.md#7).

The original serves an action of its own type, ``positionaction``. Standard messages have none like it, so here a goal
is a ``geometry_msgs/PoseStamped`` on ``goal_pose``, as RViz sends it, and a ``std_msgs/Empty`` on ``goal_reached``
reports its arrival. As there, a new goal replaces the previous one, which is then never reported.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped
from numpy.typing import NDArray
from rclpy.context import Context
from std_msgs.msg import Empty

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, TrajectoryPoint
from crazychoir_fw.ros.conversions import points_to_joint_trajectory
from crazychoir_fw.ros.names import TRAJ_PARAMS, Topic
from crazychoir_fw.ros.node import LayerNode
from crazychoir_fw.ros.pose_sources import pose_subscribe

GOAL_POSE = Topic("goal_pose", PoseStamped, 10, 10, "where to fly in the plane (m, world)")
GOAL_REACHED = Topic("goal_reached", Empty, 10, 10, "the latest goal was reached")

_LOWEST, _STEP = 0.5, 0.15  # [m]: each drone flies at a height of its own, so that they do not meet


class PointToPointPlanner_2D(LayerNode):  # noqa: N801  the original's name
    """Node ``planner``: goals in, ``traj_params`` out."""

    def __init__(
        self,
        goal_tolerance: float = 0.05,
        pose_handler: str | None = "pubsub",
        pose_topic: str | None = "odom",
        pose_callback: Callable[[], Any] | None = None,
        *,
        duration: float = 20.0,
        agent_id: int | None = None,
        parameters: Mapping[str, Any] | None = None,
        context: Context | None = None,
    ) -> None:
        """Make the node.

        Args:
            goal_tolerance: Distance in the plane at which a goal is reached (m).
            pose_handler: Where poses come from, see `crazychoir_fw.ros.pose_sources`.
            pose_topic: Topic of the pose.
            pose_callback: Called after each pose.
            duration: How long a go-to takes (s).
            agent_id: Number of the drone; None asks parameter and namespace.
            parameters: Values of parameters.
            context: Context of rclpy.

        Raises:
            RangeError: If a number is not above zero.
        """
        for name, value in (("goal_tolerance", goal_tolerance), ("duration", duration)):
            if not 0.0 < value < np.inf:
                raise RangeError(f"planner: {name} is {value}, allowed: above 0")
        super().__init__("planner", agent_id=agent_id, parameters=parameters, context=context)
        self.goal: NDArray[np.float64] | None = None
        """The goal that is flown to (m), shape (2,)."""
        self.height = _LOWEST + _STEP * self.agent_id
        """At which it flies (m)."""
        self._tolerance, self._duration = goal_tolerance, duration
        self._points = self.announce(TRAJ_PARAMS)
        self._reached = self.announce(GOAL_REACHED)
        self.listen(GOAL_POSE, self._take_goal)
        self.pose_source = pose_subscribe(pose_handler, pose_topic, self, self._take_pose, pose_callback)

    def _take_goal(self, message: PoseStamped) -> None:
        place = np.array((message.pose.position.x, message.pose.position.y, self.height))
        point = TrajectoryPoint(self._duration, place)
        self._points.publish(points_to_joint_trajectory([point], self.agent_id))
        self.goal = place[:2]

    def _take_pose(self, pose: Pose) -> None:
        if self.goal is None or pose.position is None:
            return
        if np.linalg.norm(pose.position[:2] - self.goal) < self._tolerance:
            self.goal = None
            self._reached.publish(Empty())
