"""`CrazyflieIntegrator` as a ROS 2 node: drones without firmware, one or several (docs/reference/crazychoir.md#11)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from rclpy.clock import Clock, ClockType
from rclpy.context import Context
from std_msgs.msg import Empty

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.ros.conversions import message_to_twist, to_stamp
from crazychoir_fw.ros.names import CLOCK, CMD_VEL, NAMESPACE_PATTERN, ODOM, STOP, Topic
from crazychoir_fw.ros.node import LayerNode
from crazychoir_fw.ros.odometry import OdometryTopics
from crazychoir_fw.simulation import integrator as plain

KINDS = ("fpqr", "frpy", "vel")
_MAX_BEHIND = 0.1  # [s], that a paused process makes up for


class CrazyflieIntegrator(LayerNode):
    """Node ``integrator``: ``cmd_vel`` in, ``odom`` out, with stamps and frames.

    It follows the clock of ROS; with `publish_clock` it is the source of simulated time for all nodes.
    """

    def __init__(
        self,
        integration_freq: int = 100,
        odom_freq: int | None = None,
        *,
        agents: Sequence[int] | None = None,
        command: str = "fpqr",
        publish_clock: bool = False,
        speed: float = 1.0,
        agent_id: int | None = None,
        namespace_pattern: str = NAMESPACE_PATTERN,
        parameters: Mapping[str, Any] | None = None,
        context: Context | None = None,
        **options: Any,
    ) -> None:
        """Make the node.

        Args:
            integration_freq: Steps per second.
            odom_freq: Odometry messages per second, at most `integration_freq`; None is one per step.
            agents: Numbers of the drones, all in this one node; None is the one drone of the namespace.
            command: What ``cmd_vel`` carries: ``fpqr``, ``frpy`` or ``vel``.
            publish_clock: Whether this node is the source of ``/clock``; simulated time then begins at 0.
            speed: Simulated seconds per second, where it is.
            agent_id: Number of the drone; None asks parameter and namespace.
            namespace_pattern: Namespace of drone i.
            parameters: Values of parameters: ``init_pos``, three numbers (m, world) for each drone.
            context: Context of rclpy.
            options: Of the plain integrator, such as ``drag``, ``floor`` or ``legacy``.

        Raises:
            RangeError: If a value is outside its range.
        """
        _check(command, speed)
        super().__init__(
            "integrator",
            swarm_wide=agents is not None,
            agent_id=agent_id,
            namespace_pattern=namespace_pattern,
            parameters=parameters,
            context=context,
        )
        numbers = [self.agent_id] if agents is None else [int(i) for i in agents]
        starts = self._starts(numbers, options.pop("init_pos", None))
        if publish_clock and self.is_simulated_time:
            raise RangeError("publish_clock with use_sim_time: allowed: one of them, this node would wait for itself")
        self.integrator = plain.CrazyflieIntegrator(integration_freq, odom_freq, init_pos=starts, **options)
        """The plain integrator, of as many drones as there are."""
        self.integrator.odometry_listeners.append(self._publish)
        self._command = command
        self._held = np.zeros((len(numbers), 6))
        if command != "vel":
            self._held[:, 2] = self.integrator.mass * self.integrator.gravity
        self._is_new, self._is_stopped = False, False
        self._begin: float | None = None
        self._connect(numbers, is_swarm=agents is not None)
        self._clock_publisher = self.announce(CLOCK) if publish_clock else None
        if publish_clock:
            period = 1.0 / (integration_freq * speed)
            self.create_timer(period, lambda: self._step(1), clock=Clock(clock_type=ClockType.STEADY_TIME))
        else:
            self.when_time_jumps_back(self._begin_anew)
            self.every(integration_freq, self._tick)

    def _starts(self, numbers: Sequence[int], given: Any) -> np.ndarray:
        """Return where the drones start (m, world), shape (N, 3): from the parameter, as given, or drawn."""
        start = self.declare(
            "init_pos", None, "start (m, world): x, y, z of each drone", list[float], length=3 * len(numbers)
        )
        if start is None:
            start = given if given is not None else [_drawn_start(i) for i in numbers]
        return np.reshape(np.asarray(start, float), (-1, 3))

    def _connect(self, numbers: Sequence[int], is_swarm: bool) -> None:
        """Make the topics: of this drone, or of all by their numbers."""

        def name(i: int, topic: Topic) -> str:
            return self.topic_of(i, topic.name) if is_swarm else topic.name

        self._odometry = OdometryTopics(self, [name(i, ODOM) for i in numbers])
        for row, i in enumerate(numbers):
            self.listen(CMD_VEL, self._taker(row), name(i, CMD_VEL))
        self.listen(STOP, lambda _: self.stop())
        self.create_subscription(Empty, "/resume", lambda _: self.resume(), 10)

    # ---------------------------------------------------------------- in

    def _taker(self, row: int) -> Callable[[Any], None]:
        def take(message: Any) -> None:
            twist = message_to_twist(message)
            self._held[row, :3], self._held[row, 3:] = twist.linear, twist.angular
            self._is_new = True

        return take

    def stop(self) -> None:
        """Motors off, until `resume`."""
        self._is_stopped = True
        self.integrator.command(0.0, 0.0, 0.0, 0.0)

    def resume(self) -> None:
        """Take commands again."""
        self._is_stopped, self._is_new = False, True

    def _hand_over(self) -> None:
        if self._is_new and not self._is_stopped:
            linear, angular = self._held[:, :3], self._held[:, 3:]
            if self._command == "fpqr":
                self.integrator.cmd_vel(linear, angular)
            elif self._command == "frpy":
                self.integrator.command_attitude(linear[:, 2], *angular.T)
            else:
                self.integrator.command_velocity(linear, angular[:, 2])
            self._is_new = False

    # ---------------------------------------------------------------- time

    def _tick(self, now: float) -> None:
        frequency = self.integrator.integration_freq
        if self._begin is None:
            self._begin = now - self.integrator.time
            self._publish(self.integrator.odometry)
            return
        due = round((now - self._begin - self.integrator.time) * frequency)
        most = max(1, round(_MAX_BEHIND * frequency))
        if due > most:
            self._begin += (due - most) / frequency
            due = most
        self._step(due)

    def _step(self, count: int) -> None:
        self._hand_over()
        self.integrator.step(count)
        if self._clock_publisher is not None:
            self._clock_publisher.publish(CLOCK.type(clock=to_stamp(self.integrator.time)))

    def _begin_anew(self, now: float) -> None:
        self._begin = None

    # ---------------------------------------------------------------- out

    def _publish(self, odometry: plain.Odometry) -> None:
        poses = Pose(odometry.position, odometry.quat_xyzw, odometry.velocity, odometry.rates)
        self._odometry.publish(odometry.time + (self._begin or 0.0), poses)


def _check(command: str, speed: float) -> None:
    if command not in KINDS:
        raise RangeError(f"command is {command!r}, allowed: {', '.join(KINDS)}")
    if not (math.isfinite(speed) and speed > 0.0):
        raise RangeError(f"speed is {speed}, allowed: above 0")


def _drawn_start(agent_id: int) -> np.ndarray:
    """Return where the plain integrator would begin with a drone alone."""
    return plain.CrazyflieIntegrator(agent_id=agent_id).state[0:3]
