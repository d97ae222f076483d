"""Controllers as ROS 2 nodes, with the class names and arguments of the paper (docs/reference/crazychoir.md#4)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np
from rclpy.context import Context
from std_msgs.msg import Bool

from crazychoir_fw import control as plain
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, Reference, Twist
from crazychoir_fw.control import (
    ReferenceHandler,
    SenderStrategy,
)
from crazychoir_fw.guidance.law import arguments_of
from crazychoir_fw.ros.conversions import message_to_reference, twist_to_bytes
from crazychoir_fw.ros.layer_failure import LayerGuard
from crazychoir_fw.ros.names import CMD_VEL, LATEST, REFERENCES
from crazychoir_fw.ros.node import LayerNode
from crazychoir_fw.ros.pose_sources import pose_subscribe
from crazychoir_fw.ros.pose_triggered import CLOSE, PoseTriggered
from crazychoir_fw.ros.pose_watch import PoseWatch

_REST = 1e-3  # [m/s, m/s^2], below which a reference stands still


class CrazyflieController(PoseTriggered, LayerNode):
    """Template of controllers: pose and reference in, ``cmd_vel`` out.

    Nothing is sent before the pose is known, nor when it is older than the parameter ``pose_timeout`` (s). A reference
    at rest is held; one that moves or accelerates the drone is given up when none has come for ``reference_timeout``
    (s): its publisher counts as gone, and the drone holds its position until the next reference. A subclass makes the
    plain controller, or the caller passes one as `controller`.

    A law that raises is reported on ``failure``, and the node stops sending; see `crazychoir_fw.ros.layer_failure`.

    Under simulated time each pose that is due makes a step, with its own stamp, so that results do not depend on which
    of pose and clock comes first; where poses come slower than commands, or in real time, the clock does.
    """

    command_topic = CMD_VEL
    """Where commands go."""

    def __init__(
        self,
        pose_handler: str | None = "pubsub",
        pose_topic: str | None = "odom",
        pose_callback: Callable[[], Any] | None = None,
        command_sender: SenderStrategy | None = None,
        traj_handler: ReferenceHandler | None = None,
        *,
        controller: plain.CrazyflieController | None = None,
        agent_id: int | None = None,
        parameters: Mapping[str, Any] | None = None,
        context: Context | None = None,
    ) -> None:
        """Make the node ``controller``.

        Args:
            pose_handler: Where poses come from, see `crazychoir_fw.ros.pose_sources`.
            pose_topic: Topic of the pose.
            pose_callback: Called after each pose; a filter such as `Estimator` fills in the velocities.
            command_sender: Strategy that composes the command.
            traj_handler: Which references are followed, and on which topic; None follows none.
            controller: A plain controller; the default is made by the subclass from the two arguments before.
            agent_id: Number of the drone; None asks parameter and namespace.
            parameters: Values of parameters.
            context: Context of rclpy.

        Raises:
            RangeError: If a part is missing or a parameter is outside its range.
            UnknownNameError: If there is no such source of poses.
        """
        # before the node exists: an error for a missing part must not leave a half-made node
        made = self.make_controller(command_sender, traj_handler) if controller is None else controller
        super().__init__("controller", agent_id=agent_id, parameters=parameters, context=context)
        self.controller: plain.CrazyflieController = made
        """The plain controller."""
        self._guard = LayerGuard(self, made)
        timeout = self.declare("pose_timeout", 0.5, "age of the pose at which nothing is sent any more (s)", low=0.001)
        self._watch = PoseWatch(self, timeout)
        self._patience = self.declare(
            "reference_timeout", 0.5, "age at which a moving reference is given up (s); 0 holds it for ever", low=0.0
        )
        self._has_new_reference = False
        self._reference_time: float | None = None  # [s], of the step that followed the latest one first
        self._is_idle = False
        self._latest = -np.inf  # [s], time of the latest step
        self._longest_step = CLOSE * min(made.periods)
        self._commands = self.announce(self.command_topic)
        handler = made.traj_handler
        self.reference_subscription: Any = None
        if hasattr(handler, "kind") and hasattr(handler, "topic"):
            topic = REFERENCES[handler.kind]
            self.reference_subscription = self.listen(topic, self._take_reference, handler.topic, fast=True)
            self.create_subscription(Bool, "idle", self._take_idle, LATEST)
        self.pose_source = pose_subscribe(pose_handler, pose_topic, self, self.take_pose, pose_callback)
        self.when_time_jumps_back(self._begin_anew)
        for period in made.periods:
            self.every(1.0 / period, self._tick)

    def make_controller(
        self, command_sender: SenderStrategy | None, traj_handler: ReferenceHandler | None
    ) -> plain.CrazyflieController:
        """Return the plain controller; a subclass overrides this."""
        raise NotImplementedError(f"{type(self).__name__}: give it a controller, or override make_controller")

    @property
    def current_pose(self) -> Pose:
        """The latest pose."""
        return self.controller.current_pose

    def send_input(self, twist: Twist) -> None:
        """Publish a command; may be overridden."""
        try:
            self._commands.publish(twist_to_bytes(twist))
        except RangeError as error:
            self.get_logger().error(f"command not sent: {error}", throttle_duration_sec=1.0)

    def _take_reference(self, message: Any) -> None:
        reference = message_to_reference(message, self.controller.traj_handler.kind)
        with self._guard:
            self.controller.set_reference(reference)
        self._has_new_reference = True

    def _take_idle(self, message: Bool) -> None:
        """Store whether the guidance is idle; an idle guidance sends no references."""
        self._is_idle = message.data

    def take_pose(self, pose: Pose) -> None:
        """Take the newest pose of the drone."""
        with self._guard:
            self.controller.set_pose(pose)
        self._watch.saw(pose, self.now())
        if self._is_new_pose(pose.time) and self.is_simulated_time and self._is_led_by_poses(pose.time):
            self.skip_ticks()
            self._work(pose.time)

    def _tick(self, now: float) -> None:
        if not (self.is_simulated_time and self._is_led_by_poses(now)):
            self._work(now)

    def _work(self, now: float) -> None:
        # poses and clock come in any order, but time goes forward
        self._latest = now = max(now, self._latest)
        if self._guard.failure is not None or not self._watch.is_fresh(now):
            return
        twist = None
        with self._guard:
            self._mind_references(now)
            twist = self.controller.step(now)
        if twist is not None:
            self.send_input(twist)

    def _mind_references(self, now: float) -> None:
        """Clear a moving reference once when none has come for ``reference_timeout``."""
        if self._has_new_reference:
            self._has_new_reference, self._reference_time = False, now
            return
        if self._reference_time is None or self._patience == 0.0 or now - self._reference_time <= self._patience:
            return
        self._reference_time = None
        reference = self.controller.desired_reference
        if reference is None or _is_at_rest(reference):
            return
        self.controller.clear_reference()
        if not self._is_idle:
            self.get_logger().warning(
                f"no reference for {self._patience:g} s (reference_timeout): stays where it is until the next one"
            )

    def _begin_anew(self, now: float) -> None:
        self._has_new_reference, self._reference_time = False, None
        self._latest = -np.inf
        self._forget_poses()
        self._watch.reset()
        self.controller.set_pose(Pose())
        self.controller.clear_reference()


def _is_at_rest(reference: Reference) -> bool:
    """Whether it is a place to stay at."""
    moves = (reference.velocity, reference.acceleration)
    return reference.position is not None and all(part is None or np.abs(part).max() < _REST for part in moves)


class LawController(CrazyflieController):
    """A node around a class of plain controllers; its arguments follow those of the pose source."""

    law: ClassVar[Any]
    """Class of the plain controller."""

    def __init__(
        self,
        pose_handler: str | None = "pubsub",
        pose_topic: str | None = "odom",
        pose_callback: Callable[[], Any] | None = None,
        *parts: Any,
        **options: Any,
    ) -> None:
        """Make the node.

        Args:
            pose_handler: Where poses come from.
            pose_topic: Topic of the pose.
            pose_callback: Called after each pose.
            parts: Arguments of the plain controller, in its order.
            options: Arguments of the plain controller, and of `CrazyflieController`.

        Raises:
            RangeError: If parts are missing or do not fit together.
        """
        taken = arguments_of(self.law)
        self._parts = dict(zip(taken, parts, strict=False)) | {key: options.pop(key) for key in taken if key in options}
        super().__init__(pose_handler, pose_topic, pose_callback, **options)

    def make_controller(
        self, command_sender: SenderStrategy | None, traj_handler: ReferenceHandler | None
    ) -> plain.CrazyflieController:
        """See `CrazyflieController`."""
        del command_sender, traj_handler  # they are among the parts
        return self.law(**self._parts)


class HierarchicalController(LawController):
    """Position law, attitude law and sender, each at its rate."""

    law = plain.HierarchicalController


class VelocityController(LawController):
    """A velocity law and a sender."""

    law = plain.VelocityController
