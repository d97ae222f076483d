"""Trajectory handlers as ROS 2 nodes: points on ``traj_params`` in, references out (docs/reference/crazychoir.md#7)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np
from rclpy.context import Context
from trajectory_msgs.msg import JointTrajectory

from crazychoir_fw import planning as plain
from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.common.messages import Pose, TrajectoryPoint
from crazychoir_fw.ros.conversions import joint_trajectory_to_points, reference_to_bytes
from crazychoir_fw.ros.layer_failure import LayerGuard
from crazychoir_fw.ros.names import REFERENCES, TRAJ_PARAMS, qos
from crazychoir_fw.ros.node import LayerNode
from crazychoir_fw.ros.pose_sources import pose_subscribe

_NUMBERS = 26  # of the parameter traj_params


class TrajectoryHandler(LayerNode):
    """Plans through points and publishes where the drone should be; after the end, once more, the end.

    Points that come before the first pose are planned when it is there. Points may also be given once as the parameter
    ``traj_params``, 26 numbers: times of begin and end (s), then positions, velocities, accelerations and jerks of
    begin and end (m, s, world).

    A handler that raises is reported on ``failure``, and plans no more; see `crazychoir_fw.ros.layer_failure`. Points
    that a handler of this package rejects are only logged.
    """

    plain_class: ClassVar[type[plain.TrajectoryHandler]]
    """Which plain handler a subclass wires up."""

    def __init__(
        self,
        update_frequency: float = 100.0,
        pose_handler: str | None = "pubsub",
        pose_topic: str | None = "odom",
        pose_callback: Callable[[], Any] | None = None,
        input_topic: str | None = None,
        *,
        handler: plain.TrajectoryHandler | None = None,
        agent_id: int | None = None,
        parameters: Mapping[str, Any] | None = None,
        context: Context | None = None,
        **options: Any,
    ) -> None:
        """Make the node ``trajectory``.

        Args:
            update_frequency: References per second (Hz).
            pose_handler: Where poses come from, see `crazychoir_fw.ros.pose_sources`.
            pose_topic: Topic of the pose.
            pose_callback: Called after each pose.
            input_topic: Topic of the references; None is the one of their kind.
            handler: A plain handler, in place of one that the class would make.
            agent_id: Number of the drone; None asks parameter and namespace.
            parameters: Values of parameters.
            context: Context of rclpy.
            options: Of the plain handler, such as ``yaw`` or ``legacy``.

        Raises:
            RangeError: If a number is outside its range.
            UnknownNameError: If there is no such source of poses.
        """
        if handler is None:
            handler = self.plain_class(update_frequency, input_topic, **options)
        super().__init__("trajectory", agent_id=agent_id, parameters=parameters, context=context)
        self.handler: plain.TrajectoryHandler = handler
        """The plain handler."""
        self._guard = LayerGuard(self, handler)
        self.current_pose = Pose()
        """The latest pose."""
        self._pending: list[TrajectoryPoint] | None = None
        self._was_active = False
        given = self.declare(
            "traj_params",
            None,
            "a trajectory: times of begin and end (s), positions, velocities, accelerations, jerks of both (m, s)",
            list[float],
            length=_NUMBERS,
        )
        if given is not None:
            self._pending = _points_of(given)
        self.reference_publisher: Any = self.announce(REFERENCES[handler.kind], handler.input_topic)
        # a handler wants the newest trajectory only
        self.listen(TRAJ_PARAMS, self._take_message, profile=qos(1))
        self.pose_source = pose_subscribe(pose_handler, pose_topic, self, self.take_pose, pose_callback)
        self.when_time_jumps_back(self._begin_anew)
        self.every(handler.update_frequency, self._tick)

    def take_pose(self, pose: Pose) -> None:
        """Take the newest pose of the drone."""
        self.current_pose = pose

    def _take_message(self, message: JointTrajectory) -> None:
        self._pending = joint_trajectory_to_points(message)
        self._plan(self.now())

    def _plan(self, now: float) -> None:
        if self._pending is None or self.current_pose.position is None or self._guard.failure is not None:
            return
        points, self._pending = self._pending, None
        with self._guard:
            try:
                self.handler.set_trajectory(points, self.current_pose, now)
            except CrazychoirError as error:
                self.get_logger().error(f"{TRAJ_PARAMS.name}: {error}")

    def _tick(self, now: float) -> None:
        if self.current_pose.position is None:
            return
        self._plan(now)
        if self._guard.failure is not None:
            return
        with self._guard:
            active = self.handler.is_active(now)
            if active or self._was_active:
                self.send_reference(now)
            self._was_active = active

    def send_reference(self, now: float) -> None:
        """Publish the reference of a time (s); may be overridden."""
        reference = self.handler.evaluate(now)
        if reference is not None:
            self.reference_publisher.publish(reference_to_bytes(reference, self.handler.kind))

    def _begin_anew(self, now: float) -> None:
        self.handler.reset()
        self.current_pose = Pose()
        self._pending, self._was_active = None, False


def _points_of(numbers: list[float]) -> list[TrajectoryPoint]:
    """Return the end of a trajectory of two points; where it begins is where the drone is."""
    times, rows = numbers[:2], np.reshape(numbers[2:], (4, 2, 3))
    return [TrajectoryPoint(times[1] - times[0], *rows[:, 1])]


class AccelerationTrajHandler(TrajectoryHandler):
    """References are accelerations."""

    plain_class = plain.AccelerationTrajHandler


class FullStateTrajHandler(TrajectoryHandler):
    """References are position, velocity, acceleration and yaw."""

    plain_class = plain.FullStateTrajHandler


class Polynomial7th(FullStateTrajHandler):
    """Degree 7 from point to point."""

    plain_class = plain.Polynomial7th


class Spline(FullStateTrajHandler):
    """Cubic splines through the points."""

    plain_class = plain.Spline


class SplinePosition(Spline):
    """The positions of cubic splines."""

    plain_class = plain.SplinePosition


class MinimumSnap(FullStateTrajHandler):
    """The minimum-snap curve through the points."""

    plain_class = plain.MinimumSnap
