"""`SimulationNode`: one node for a world of drones, whatever their number.

Each drone has the topics of the table: it subscribes to ``cmd_vel`` or ``traj_params`` and publishes ``odom``;
``/clock`` is simulated time.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from rclpy.context import Context
from rclpy.task import Future
from sensor_msgs.msg import Imu
from std_msgs.msg import Bool, Empty

from crazychoir_fw.common.errors import CrazychoirError, RangeError
from crazychoir_fw.common.messages import Pose, TrajectoryPoint, Twist
from crazychoir_fw.ros.buttons import serve_trigger
from crazychoir_fw.ros.conversions import (
    bytes_to_twist,
    joint_trajectory_to_points,
    pose_to_pose_stamped,
    to_stamp,
    to_vector3,
)
from crazychoir_fw.ros.lockstep import Answers
from crazychoir_fw.ros.names import (
    BODY_FRAME,
    CLOCK,
    CMD_VEL,
    LATEST,
    MOCAP_POSE,
    NAMESPACE_PATTERN,
    ODOM,
    REFERENCES,
    STOP,
    TRAJ_PARAMS,
    qos,
)
from crazychoir_fw.ros.node import LayerNode
from crazychoir_fw.ros.odometry import OdometryTopics

KINDS = ("fpqr", "frpy", "vel", "xyz")
_LOOK_EVERY = 0.25  # [s], wall: period of the check for subscribers


class Host(Protocol):
    """The simulation behind the node: `PluginHost`, or a backend of experiments."""

    names: Sequence[str]

    @property
    def time(self) -> float:
        """Time (s)."""

    def poses(self) -> Pose:
        """Return the odometry of all drones."""

    def send(self, indices: Sequence[int], twist: Twist, kind: str) -> None:
        """Hand over commands."""

    def go_to(self, index: int, point: TrajectoryPoint) -> None:
        """Fly to a point."""

    def advance(self, seconds: float) -> None:
        """Advance simulated time."""

    def stop(self, indices: Sequence[int]) -> None:
        """Motors off."""


@dataclass(frozen=True)
class Pace:
    """How fast simulated time advances."""

    speed: float | None = 1.0
    """Simulated seconds per second; None is as fast as possible."""
    lockstep: bool = False
    """Whether each step waits until all parties that are not silent have answered the last odometry."""
    deadline: float = 2.0
    """Longest wait in a step (s, wall clock); a party that has not answered by then counts as silent."""
    unattended: bool = False
    """Whether time advances without subscribers. In real time it always does."""


class CommandInbox:
    """The latest commands of drones on ``cmd_vel``."""

    def __init__(self, node: SimulationNode, count: int) -> None:
        """Subscribe to the commands of `count` drones."""
        self._node = node
        self._linear, self._angular = np.zeros((count, 3)), np.zeros((count, 3))
        self.is_new = np.zeros(count, bool)
        """Whether each drone has a command since the last `take`, shape (N,)."""
        for i in range(count):
            node.listen_to_bytes(CMD_VEL, self._taker(i), node.topic_of(i, CMD_VEL.name))

    def _taker(self, i: int) -> Callable[[bytes], None]:
        node = self._node

        def take(data: bytes) -> None:
            twist = bytes_to_twist(data)
            self._linear[i], self._angular[i], self.is_new[i] = twist.linear, twist.angular, True
            if node.latencies is not None:
                node.latencies.append(time.perf_counter() - node.last_step_wall)
            node.answer((i, CMD_VEL.name))

        return take

    def take(self, wanted: Any = True) -> tuple[NDArray[np.intp], Twist]:
        """Return the wanted drones with commands since the last call, and these commands, arrays of shape (n, 3)."""
        indices = np.flatnonzero(self.is_new & wanted)
        self.is_new[:] = False
        return indices, Twist(self._linear[indices], self._angular[indices])


class SimulationNode(LayerNode):
    """The drones of a world as topics.

    Each `step` advances it; `run` calls that at the chosen pace.
    """

    def __init__(
        self,
        host: Host,
        *,
        command: str | None = "fpqr",
        rate: float = 100.0,
        pace: Pace = Pace(),
        answers: Mapping[str, Sequence[int]] | None = None,
        imu: bool = False,
        mocap_noise: float | None = None,
        seed: int = 0,
        namespace_pattern: str = NAMESPACE_PATTERN,
        context: Context | None = None,
    ) -> None:
        """Make the node; nothing moves yet.

        Args:
            host: The simulation behind the node.
            command: Kind of the commands: ``fpqr``, ``frpy`` or ``vel`` on ``cmd_vel``, ``xyz`` on ``traj_params``;
                None: the owner of the node subscribes to commands and buttons.
            rate: Odometry per simulated second (Hz), a divisor of 1000.
            pace: How fast simulated time advances.
            answers: In lockstep, topics (``cmd_vel``, ``acceleration``, …, or ``guidance`` on ``answered``) by whose
                messages drones answer each odometry, with the numbers of these drones; all with ``cmd_vel`` by default.
            imu: Whether ``imu`` is published, if the host knows it.
            mocap_noise: Standard deviation (m) of the poses of motion capture on ``/vicon/cf{i}/cf{i}``; None: there is
                no motion capture.
            seed: Of that noise.
            namespace_pattern: Namespace of drone i.
            context: Context of rclpy.

        Raises:
            RangeError: If an argument is outside its range.
        """
        if command is not None and command not in KINDS:
            raise RangeError(f"command is {command!r}, allowed: {', '.join(KINDS)}")
        if not (1 <= rate <= 1000 and 1000 % rate == 0):
            raise RangeError(f"rate is {rate!r} Hz, allowed: a divisor of 1000")
        super().__init__("simulation", swarm_wide=True, namespace_pattern=namespace_pattern, context=context)
        self.host = host
        self.period = 1.0 / rate
        self.pace = pace
        self.steps = 0
        """How many steps have been made."""
        self.last_step_wall = 0.0
        """When the latest odometry went out (s, steady clock)."""
        self.while_waiting: Callable[[], None] = lambda: None
        """Called at least every 50 ms while answers are pending."""
        self.latencies: list[float] | None = None
        """Times from an odometry to the command that answers it (s, wall); None records nothing."""
        self._kind = command
        self._all_answered = Future()
        self._stopping = False
        self._stopped = False
        count = len(host.names)
        self._publish_topics(count, imu, mocap_noise, seed)
        if answers is None:
            answers = {} if command in (None, "xyz") else {CMD_VEL.name: range(count)}
        self.answers = Answers((i, topic) for topic, drones in answers.items() for i in drones)
        for topic, drones in answers.items():
            if topic != CMD_VEL.name:  # `CommandInbox` subscribes to that
                for i in drones:
                    self._listen_for_answers(i, topic)
        self.commands = None if command in (None, "xyz") else CommandInbox(self, count)
        """Commands received on ``cmd_vel``."""
        if command is not None:
            self._subscribe_topics(count)
        self._looked = -1e9
        self._due: float | None = None

    def _publish_topics(self, count: int, imu: bool, mocap_noise: float | None, seed: int) -> None:
        self._clock_publisher = self.announce(CLOCK)
        self._odometry = OdometryTopics(self, [self.topic_of(i, ODOM.name) for i in range(count)])
        self._imu: list[Any] = []
        if imu and hasattr(self.host, "imu"):
            self._imu = [self.create_publisher(Imu, self.topic_of(i, "imu"), qos(10)) for i in range(count)]
        self._mocap: list[Any] = []
        self._mocap_noise = mocap_noise
        if mocap_noise is not None:
            self._random = np.random.default_rng(seed)
            self._mocap = [self.announce(MOCAP_POSE, MOCAP_POSE.name.format(d=i)) for i in range(count)]

    def _subscribe_topics(self, count: int) -> None:
        self._idle = np.zeros(count, bool)
        for i in range(count):
            if self._kind == "xyz":
                self.listen(TRAJ_PARAMS, self._point_taker(i), self.topic_of(i, TRAJ_PARAMS.name))
            self.create_subscription(Bool, self.topic_of(i, "idle"), self._idle_taker(i), LATEST)
        self.listen(STOP, lambda _: self.stop_all())
        serve_trigger(self, "/resume", lambda: self.resume_all(), "the drones take commands again")
        self.create_subscription(STOP.type, "/resume", lambda _: self.resume_all(), 10)

    def _listen_for_answers(self, index: int, topic: str) -> None:
        party = (index, topic)
        kind = REFERENCES[topic].type if topic in REFERENCES else Empty
        self.create_subscription(kind, self.topic_of(index, topic), lambda _: self.answer(party), 10, raw=True)

    def _idle_taker(self, index: int) -> Callable[[Bool], None]:
        """Return the callback of ``idle``: motors off while a guidance is idle, whatever its controller commands."""

        def take(message: Bool) -> None:
            if message.data and not self._idle[index]:
                self.host.stop([index])
            elif self._idle[index] and not message.data and not self._stopped:
                self._resume([index])
            self._idle[index] = message.data

        return take

    def _point_taker(self, index: int) -> Callable[[Any], None]:
        def take(message: Any) -> None:
            # of a drawn trajectory, the end: the planner on board flies to points
            self.host.go_to(index, joint_trajectory_to_points(message)[-1])

        return take

    def answer(self, party: tuple[int, str]) -> None:
        """Record that a party has answered the latest odometry."""
        if self.answers.take(party):
            self.get_logger().warning(f"{self.host.names[party[0]]}: answers again on {party[1]}")
        if self.answers.is_complete and not self._all_answered.done():
            self._all_answered.set_result(None)

    # ---------------------------------------------------------------- buttons

    def stop_all(self) -> None:
        """Motors of all drones off, until `resume_all`."""
        self._stopped = True
        self.host.stop(range(len(self.host.names)))

    def resume_all(self) -> None:
        """Take commands again, where the host can."""
        self._stopped = False
        self._resume(range(len(self.host.names)))

    def _resume(self, indices: Sequence[int]) -> None:
        resume = getattr(self.host, "resume", None)
        if resume is not None:
            resume(indices)

    # ---------------------------------------------------------------- time

    def step(self) -> None:
        """Pass new commands to the host, advance by one period, and publish the state."""
        if self.commands is not None:
            indices, twist = self.commands.take(False if self._stopped else ~self._idle)
            if indices.size:
                try:
                    self.host.send(indices.tolist(), twist, self._kind)
                except CrazychoirError as error:
                    self.get_logger().warning(str(error), throttle_duration_sec=1.0)
        self.host.advance(self.period)
        self.steps += 1
        self.publish()

    def publish(self) -> None:
        """Publish the state: odometry first, then the clock, which triggers the nodes."""
        self.answers.ask()
        pose, now = self.host.poses(), self.host.time
        self.last_step_wall = time.perf_counter()
        self._odometry.publish(now, pose)
        if self._imu:
            self._publish_imu(now)
        if self._mocap:
            self._publish_mocap(now, self.host.truth() if hasattr(self.host, "truth") else pose)
        self.publish_clock()

    def _publish_imu(self, now: float) -> None:
        for publisher, rates, acceleration in zip(self._imu, *self.host.imu(), strict=True):
            message = Imu(angular_velocity=to_vector3("rates", rates))
            message.header.stamp, message.header.frame_id = to_stamp(now), BODY_FRAME
            message.linear_acceleration = to_vector3("acceleration", acceleration)
            message.orientation_covariance[0] = -1.0  # there is no attitude
            publisher.publish(message)

    def _publish_mocap(self, now: float, truth: Pose) -> None:
        noise = self._random.normal(0.0, self._mocap_noise, truth.position.shape)
        for publisher, place, attitude in zip(self._mocap, truth.position + noise, truth.orientation, strict=True):
            publisher.publish(pose_to_pose_stamped(Pose(place, attitude, time=now)))

    def publish_clock(self) -> None:
        """Publish the time of the host."""
        self._clock_publisher.publish(CLOCK.type(clock=to_stamp(self.host.time)))

    def run(self, executor: Any, until: float | None = None) -> None:
        """Let time go on until it is `until` (s), or `finish` is called.

        Args:
            executor: The executor that this node is in; it is worked on meanwhile.
            until: Simulated time of the end (s); None has no end.
        """
        self.publish()
        while not self._stopping and self.context.ok() and (until is None or self.host.time < until - 1e-9):
            if self.is_due(executor):
                self.step()

    def exchange(self, executor: Any) -> None:
        """Publish the state, and process messages until the next step may be made."""
        self.publish()
        while not self._stopping and self.context.ok() and not self.is_due(executor):
            pass

    def finish(self) -> None:
        """Make `run` return."""
        self._stopping = True

    def is_due(self, executor: Any) -> bool:
        """Process messages for a short time; return whether the next step may be made."""
        if self._must_hold():
            executor.spin_once(timeout_sec=0.02)
            self._due = None
            return False
        if self.pace.lockstep and not self._everybody_answered(executor):
            return False
        return self._is_time(executor)

    def _must_hold(self) -> bool:
        """Whether to hold time, since no node receives it."""
        if self.pace.unattended or (self.pace.speed is not None and not self.pace.lockstep):
            return False
        if self.pace.lockstep:
            return bool(self.answers.parties) and not self.answers.is_anybody_there
        now = time.monotonic()
        if now - self._looked > _LOOK_EVERY:
            self._looked = now
            self._listened_to = any(publisher.get_subscription_count() for publisher in self._odometry.publishers)
        return not self._listened_to

    def _everybody_answered(self, executor: Any) -> bool:
        deadline = time.monotonic() + self.pace.deadline
        while not self.answers.is_complete:
            remaining = deadline - time.monotonic()
            if remaining <= 0.0:
                for index, topic in self.answers.give_up():
                    self.get_logger().warning(
                        f"{self.host.names[index]}: no answer on {topic} within {self.pace.deadline:g} s, "
                        "waited for no more until heard again"
                    )
                break
            self._all_answered = Future()
            executor.spin_until_future_complete(self._all_answered, timeout_sec=min(remaining, 0.05))
            self.while_waiting()
            if self._stopping or not self.context.ok():
                return False
        return True

    def _is_time(self, executor: Any) -> bool:
        if self.pace.speed is None:
            if not self.pace.lockstep or not self.answers.is_anybody_there:
                work_off(executor)
            return True
        now = time.monotonic()
        period = self.period / self.pace.speed
        # after a long delay the schedule restarts, without catching up
        if self._due is None or now - self._due > 10.0 * period:
            self._due = now
        if now < self._due:
            executor.spin_once(timeout_sec=self._due - now)
            return False
        self._due += period
        return True


def work_off(executor: Any) -> None:
    """Process all pending events, and wait for no others."""
    # a task queues up behind all events that are there
    done: list[bool] = []
    executor.create_task(lambda: done.append(True))
    while not done:
        executor.spin_once(timeout_sec=0.1)
