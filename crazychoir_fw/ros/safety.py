"""Collision avoidance as ROS 2 nodes, with the class names of the original (docs/reference/crazychoir.md#9).

One node finds the neighbors of all drones, see `crazychoir_fw.ros.neighbor_sensing`.

A drone without fresh ``closest_robots`` holds its position until the next message.

Under simulated time a node works on a pose when it has received all other inputs of that time, so that results do not
depend on the order of messages. A missing input holds up one step; later steps do not wait until it is received again.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rclpy.context import Context

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, Twist
from crazychoir_fw.control import SafeHierarchicalController as PlainSafeHierarchicalController
from crazychoir_fw.control import safety as plain
from crazychoir_fw.control.periodic_timer import PeriodicTimer
from crazychoir_fw.ros.controller import CrazyflieController, HierarchicalController
from crazychoir_fw.ros.conversions import message_to_reference, message_to_twist, to_vector3, twist_to_bytes
from crazychoir_fw.ros.layer_failure import LayerGuard
from crazychoir_fw.ros.names import ACCELERATION, CLOSEST_ROBOTS, CMD_VEL, CMD_VEL_DES, Topic
from crazychoir_fw.ros.neighbor_sensing import message_to_closest
from crazychoir_fw.ros.node import LayerNode
from crazychoir_fw.ros.pose_sources import pose_subscribe
from crazychoir_fw.ros.pose_triggered import CLOSE, PoseTriggered
from crazychoir_fw.ros.pose_watch import PoseWatch

Array = NDArray[np.float64]

_SAME = 1e-7  # [s]: stamps are whole nanoseconds


# ---------------------------------------------------------------- what belongs to one time


class Gathering:
    """Calls ``work(time)`` for each pose once everything that belongs to it has come.

    If the next pose comes first, an input is missing: from then on ``work`` runs at each pose without waiting, until a
    pose has all its inputs again.
    """

    def __init__(self, work: Callable[[float], None], wants_desired: bool) -> None:
        """Set the callback, and whether a desired input belongs to each pose."""
        self._work = work
        self._wants_desired = wants_desired
        self.reset()

    def reset(self) -> None:
        """Forget all times."""
        self._waiting: float | None = None
        self._closest = -math.inf
        self._has_desired = False
        self._is_patient = True

    def took_pose(self, time: float) -> None:
        """Take the time of a pose (s)."""
        if self._waiting is not None:
            self._is_patient = False
        self._waiting = time
        self._try()

    def took_closest(self, time: float) -> None:
        """Take the time of a ``closest_robots`` (s)."""
        self._closest = time
        self._try()

    def took_desired(self) -> None:
        """Take a desired input."""
        self._has_desired = True
        self._try()

    def _try(self) -> None:
        if self._waiting is None:
            return
        is_complete = self._closest >= self._waiting - _SAME and (self._has_desired or not self._wants_desired)
        if not (is_complete or not self._is_patient):
            return
        self._is_patient = self._is_patient or is_complete
        time, self._waiting, self._has_desired = self._waiting, None, False
        self._work(time)


class _Sight:
    """Tracks whether ``closest_robots`` is fresh; logs each change."""

    def __init__(self, node: LayerNode, take: Callable[[Pose], None], came: Callable[[float], None]) -> None:
        self._node, self._take, self._came_at = node, take, came
        self._timeout = node.declare(
            "closest_timeout", 0.5, "age of closest_robots at which the drone stays where it is (s)", low=0.001
        )
        self._heard: float | None = None
        self._is_blind = False
        node.listen(CLOSEST_ROBOTS, self._listen)

    def _listen(self, message: Any) -> None:
        time, _, poses = message_to_closest(message)
        self._heard = max(self._node.now(), time)
        self._take(poses)
        self._came_at(time)

    @property
    def has_seen(self) -> bool:
        return self._heard is not None

    def is_clear(self, now: float) -> bool:
        is_blind = self._heard is None or now - self._heard > self._timeout
        if is_blind != self._is_blind:
            self._is_blind = is_blind
            if is_blind:
                self._node.get_logger().warning(
                    f"no closest_robots for {self._timeout:g} s (closest_timeout): stays where it is"
                )
            else:
                self._node.get_logger().info("closest_robots again: goes on")
        return not is_blind

    def reset(self) -> None:
        self._heard = None


# ---------------------------------------------------------------- controllers


class SafeController(CrazyflieController):
    """A controller that takes the neighbors of its drone, such as a plain `SafeHierarchicalController`.

    The node sends nothing before the first ``closest_robots``. Once that is stale, the drone holds its position.
    """

    def __init__(self, *args: Any, **options: Any) -> None:
        """Make the node ``controller``; arguments as of `CrazyflieController`."""
        self._gathering = Gathering(self._work_on, wants_desired=False)
        self._sight: _Sight | None = None
        super().__init__(*args, **options)
        self._sight = _Sight(self, self._take_closest, self._gathering.took_closest)

    def _take_closest(self, poses: Pose) -> None:
        self.controller.set_closest(poses)  # type: ignore[attr-defined]

    def _work(self, now: float) -> None:
        if self._sight is None:
            return
        if self.is_simulated_time and self._is_led_by_poses(now):
            self._gathering.took_pose(now)
        else:
            self._work_on(now)

    def _work_on(self, now: float) -> None:
        assert self._sight is not None
        if not self._sight.has_seen:
            return
        if not self._sight.is_clear(now):
            # whatever the reference
            self.controller.clear_reference() if self.controller.desired_reference is not None else None
        super()._work(now)

    def _begin_anew(self, now: float) -> None:
        self._gathering.reset()
        if self._sight is not None:
            self._sight.reset()
        super()._begin_anew(now)


class SafeHierarchicalController(SafeController, HierarchicalController):
    """Position law that avoids neighbors, attitude law and sender, each at its rate."""

    law = PlainSafeHierarchicalController


class DesiredVelocityController(CrazyflieController):
    """A controller of velocities in front of a filter: its commands go to ``cmd_vel_des``."""

    command_topic = CMD_VEL_DES


# ---------------------------------------------------------------- filters between controller and drone


class CollisionAvoidance(PoseTriggered, LayerNode):
    """A filter as a node: ``{topic}_des``, ``closest_robots`` and poses in, the safe input on ``{topic}`` out.

    The classes below derive from it; for a plain filter, pass it as `avoidance`.
    """

    def __init__(
        self,
        pose_handler: str | None = "pubsub",
        pose_topic: str | None = "odom",
        pose_callback: Callable[[], Any] | None = None,
        node_frequency: float = 100.0,
        safety_filter: plain.BarrierFilter | None = None,
        *,
        input_topic_name: str | None = None,
        avoidance: plain.CollisionAvoidance | None = None,
        agent_id: int | None = None,
        parameters: Mapping[str, Any] | None = None,
        context: Context | None = None,
        **options: Any,
    ) -> None:
        """Make the node ``collision_avoidance``.

        Args:
            pose_handler: Where poses come from, see `crazychoir_fw.ros.pose_sources`.
            pose_topic: Topic of the pose.
            pose_callback: Called after each pose.
            node_frequency: How often the latest desired input is filtered (Hz).
            safety_filter: The filter; needed unless `avoidance` is given.
            input_topic_name: Topic of the safe input; None is the default of the filter.
            avoidance: A plain collision avoidance.
            agent_id: Number of the drone; None asks parameter and namespace.
            parameters: Values of parameters: ``pose_timeout``, ``closest_timeout`` and ``desired_timeout`` (s), ages
                at which the drone stays where it is; of poses, at which nothing is sent.
            context: Context of rclpy.
            options: Of `LayerNode`.

        Raises:
            RangeError: If a part is missing or of the wrong kind.
        """
        made = self._make(safety_filter) if avoidance is None else avoidance
        super().__init__("collision_avoidance", agent_id=agent_id, parameters=parameters, context=context, **options)
        self.avoidance: Any = made
        """The plain filter."""
        self._guard = LayerGuard(self, made)
        timeout = self.declare("pose_timeout", 0.5, "age of the pose at which nothing is sent any more (s)", low=0.001)
        self._patience = self.declare(
            "desired_timeout", 0.5, "age of the desired input at which the drone stays where it is (s)", low=0.001
        )
        self._watch = PoseWatch(self, timeout)
        self._schedule = PeriodicTimer(node_frequency)
        self._longest_step = CLOSE * self._schedule.period
        self._desired_at = -math.inf
        topic: Topic = {"cmd_vel": CMD_VEL, "acceleration": ACCELERATION}[made.input_topic_name]
        name = input_topic_name or topic.name
        self._is_twist = topic is CMD_VEL
        self._output = self.announce(topic, name)
        self._gathering = Gathering(self._work, wants_desired=True)
        self.listen(topic, self._take_desired, f"{name}_des")
        self._sight = _Sight(self, made.set_closest, self._gathering.took_closest)
        self.pose_source = pose_subscribe(pose_handler, pose_topic, self, self.take_pose, pose_callback)
        self.when_time_jumps_back(self._begin_anew)
        self.every(node_frequency, self._tick)

    _plain: Any = None

    def _make(self, safety_filter: plain.BarrierFilter | None) -> plain.CollisionAvoidance:
        if self._plain is None:
            raise RangeError(f"{type(self).__name__}: avoidance is None, allowed: one of crazychoir_fw.control.safety")
        return self._plain(safety_filter)

    def _take_desired(self, message: Any) -> None:
        if self._is_twist:
            self.avoidance.set_desired(message_to_twist(message))
        else:
            self.avoidance.set_desired(message_to_reference(message, "acceleration").acceleration)
        self._desired_at = max(self.now(), self._pose_time)
        self._gathering.took_desired()

    def take_pose(self, pose: Pose) -> None:
        """Take the newest pose of the drone."""
        self.avoidance.set_pose(pose)
        self._watch.saw(pose, self.now())
        if self._is_new_pose(pose.time) and self.is_simulated_time and self._is_led_by_poses(pose.time):
            self._gathering.took_pose(pose.time)

    def _tick(self, now: float) -> None:
        if not (self.is_simulated_time and self._is_led_by_poses(now)):
            self._work(now)

    def _work(self, now: float) -> None:
        if not (self._watch.is_fresh(now) and self._sight.has_seen and self._schedule.is_due(now)):
            return
        safe = None
        if self._guard.failure is None:
            with self._guard:
                safe = self.avoidance.step()
                if safe is not None and (not self._sight.is_clear(now) or now - self._desired_at > self._patience):
                    safe = self.avoidance.standstill()
        if safe is None or self._guard.failure is not None:
            return
        if self._is_twist:
            self._output.publish(twist_to_bytes(safe))
        else:
            self._output.publish(to_vector3("acceleration", safe))

    def _begin_anew(self, now: float) -> None:
        del now
        self._forget_poses()
        self._desired_at = -math.inf
        self._gathering.reset()
        self._sight.reset()
        self._watch.reset()
        self.avoidance.set_desired(None)
        self.avoidance.set_pose(Pose())


class SingleIntegratorCollisionAvoidance(CollisionAvoidance):
    """Of velocities: ``cmd_vel_des`` in, ``cmd_vel`` out."""

    _plain = plain.SingleIntegratorCollisionAvoidance


class DoubleIntegratorCollisionAvoidance(CollisionAvoidance):
    """Of accelerations: ``acceleration_des`` in, ``acceleration`` out."""

    _plain = plain.DoubleIntegratorCollisionAvoidance


class UnicycleCollisionAvoidance(CollisionAvoidance):
    """Of robots that drive and turn: ``cmd_vel_des`` in, ``cmd_vel`` out."""

    _plain = plain.UnicycleCollisionAvoidance


class EveryRound:
    """A plain controller that repeats its latest command in rounds without a new one, since lockstep needs answers."""

    def __init__(self, controller: Any, rate: float) -> None:
        """Wrap a controller in rounds of a rate (Hz)."""
        self._controller = controller
        self._period = 1.0 / rate
        self._latest: Twist | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._controller, name)

    @property
    def periods(self) -> tuple[float, ...]:
        """That of the rounds (s)."""
        return (self._period,)

    def step(self, now: float) -> Twist | None:
        """See `CrazyflieController`."""
        self._latest = self._controller.step(now) or self._latest
        return self._latest
