"""The node around any guidance.

No callback blocks on a round. A pose begins the round, each callback adds the message of a neighbor, and the last
message makes the node decide. A round with missing messages ends at its deadline: by the clock of ROS, and also by the
wall clock, since simulated time may stand still while a simulation waits for this node.

Neighbors that stop or resume sending are reported on ``lost_neighbors`` (`std_msgs/String`, "lost agent_3",
"rejoined agent_3") and in the log. A guidance that raises is reported on ``failure``, and decides no more; see
`crazychoir_fw.ros.layer_failure`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.context import Context
from std_msgs.msg import Bool, Empty, String

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.guidance import Outputs
from crazychoir_fw.ros.communicating import CommunicatingNode
from crazychoir_fw.ros.conversions import points_to_joint_trajectory, reference_to_bytes
from crazychoir_fw.ros.layer_failure import LayerGuard
from crazychoir_fw.ros.names import BUTTONS, LAST_BUTTON, LATEST, ODOM, REFERENCES, TRAJ_PARAMS
from crazychoir_fw.ros.pose_sources import pose_subscribe
from crazychoir_fw.ros.pose_triggered import CLOSE, PoseTriggered
from crazychoir_fw.ros.statistics import StatisticsTeller
from crazychoir_fw.ros.wall_timeouts import RoundResync, WallTimeoutClock

ANSWERED = "answered"
"""Topic on which a guidance answers each tick in lock step."""

_SAME_PRESS = 0.05  # [s]
_MISSED = 0.5  # of the patience: threshold of `RoundResync`, to detect that this node is a round behind
_LOOK_EVERY = 0.05  # [s], wall: period of the timeout check of an open round

Build = Callable[["GuidanceNode"], Any]
"""Makes the plain guidance of a node, once its parameters and topics are there."""


class GuidanceNode(PoseTriggered, CommunicatingNode):
    """Wires a guidance to topics: pose and buttons in, references and trajectories out.

    The nodes of `crazychoir_fw.ros.guidance` derive from it. For a plain guidance, pass a function that makes it as
    `build`.
    """

    def __init__(
        self,
        build: Build,
        *,
        node_name: str = "guidance",
        update_frequency: float = 100.0,
        pose_handler: str | None = "pubsub",
        pose_topic: str | None = "odom",
        pose_callback: Callable[[], None] | None = None,
        input_topic: str | None = None,
        agent_id: int | None = None,
        parameters: Mapping[str, Any] | None = None,
        context: Context | None = None,
    ) -> None:
        """Make the node.

        Args:
            build: Makes the plain guidance.
            node_name: Its fixed name.
            update_frequency: Rounds per second (Hz).
            pose_handler: Where poses come from, see `crazychoir_fw.ros.pose_sources`.
            pose_topic: Topic of the pose.
            pose_callback: Called after each pose.
            input_topic: Where references go, if not where their kind usually does.
            agent_id: Number of the drone; None asks parameter and namespace.
            parameters: Values of parameters.
            context: Context of rclpy.
        """
        super().__init__(node_name, agent_id=agent_id, parameters=parameters, context=context)
        self.update_frequency = update_frequency
        self.patience: float = self.declare(
            "patience", 0.5, "longest wait for neighbors in a round (s, wall clock)", low=0.001, high=60.0
        )
        self._answers = None
        if self.declare("lockstep", False, "whether each tick is answered on the topic answered"):
            self._answers = self.create_publisher(Empty, ANSWERED, 10)
        self.guidance: Any = build(self)
        """The plain guidance."""
        self._guard = LayerGuard(self, self.guidance, self._answer)  # no step waits for it
        # a guidance without this pace has rounds that span many steps, and no step waits for one
        is_paced = getattr(self.guidance, "is_paced_by_rounds", True)
        self._has_rounds = hasattr(self.guidance, "begin_round") and is_paced
        self._in_round = False
        self._has_answered = False  # the step, while its round is open
        # messages that get lost on purpose are not worth holding time: rounds end by the deadline of simulated time
        self._answers_early: bool = self.declare(
            "answers_early", False, "whether a step is answered while its round waits for neighbors"
        )
        self._reference_answers: bool = self.declare(
            "reference_answers", False, "whether a reference answers its step, so that answered is for steps without"
        )
        self._longest_step, self._is_led = CLOSE / update_frequency, False
        self._time = WallTimeoutClock(self._latest_time, self.patience)
        self._lost: frozenset[int] = frozenset()
        self._idle: bool | None = None
        self._has_pose = False
        self._last_press: tuple[str, float] | None = None
        communicator = getattr(self.guidance, "communicator", None)
        self._statistics: StatisticsTeller | None = None
        if communicator is not None and communicator.in_neighbors + communicator.out_neighbors:
            self._statistics = StatisticsTeller(self, communicator)
        self._announce(input_topic)
        self._hear_poses(pose_handler, pose_topic, pose_callback)
        self._hear_buttons()
        if self._has_rounds:
            self._watch_rounds()
        self._missed: RoundResync | None = None
        if self._answers is not None and self._has_rounds and communicator is not None and not self._answers_early:
            self._missed = RoundResync(communicator, _MISSED * self.patience)
        if self.transport is not None:
            self.transport.when_received.append(self._take_message)
        self.every(update_frequency, self._tick)

    def _announce(self, input_topic: str | None) -> None:
        self._kind = getattr(self.guidance, "kind", "acceleration")
        self.reference_publisher: Any = self.announce(REFERENCES[self._kind], input_topic)
        self._trajectory = self.announce(TRAJ_PARAMS)
        self._idle_publisher = self.create_publisher(Bool, "idle", LATEST)

    def _hear_poses(self, handler: str | None, topic: str | None, callback: Callable[[], None] | None) -> None:
        self.pose_source = pose_subscribe(handler, topic, self, self.take_pose, callback)
        for other in getattr(self.guidance, "watched", ()):
            of_other = self.topic_of(other, ODOM.name)
            pose_subscribe("pubsub", of_other, self, lambda pose, j=other: self._see(j, pose))

    def _hear_buttons(self) -> None:
        for name, topic in BUTTONS.items():
            # all drones at once, or this one alone
            for where in (topic.name, topic.name.lstrip("/")):
                self.listen(topic, lambda _, pressed=name: self.press(pressed), where)
        for where in (f"/{LAST_BUTTON}", LAST_BUTTON):
            self.create_subscription(String, where, self._take_last_button, LATEST)

    def _watch_rounds(self) -> None:
        self._lost_publisher = self.create_publisher(String, "lost_neighbors", 10)
        self.create_timer(_LOOK_EVERY, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))

    # ---------------------------------------------------------------- in

    def _see(self, other: int, pose: Pose) -> None:
        """Pass the pose of a watched drone to the guidance."""
        if self._guard.failure is None:
            with self._guard:
                self.guidance.see(other, pose)

    def take_pose(self, pose: Pose) -> None:
        """Take the newest pose of the drone."""
        self._has_pose = pose.position is not None
        with self._guard:
            self.guidance.set_pose(pose)
        if not self._is_new_pose(pose.time):
            return
        self._is_led = self.is_simulated_time and self._is_led_by_poses(pose.time)
        if self._is_led:
            self.skip_ticks()
            self._work()

    def _latest_time(self) -> float:
        """Return the time (s): that of the newest pose where simulated poses lead."""
        # asking the clock of a node takes 20 µs
        return self._pose_time if self._is_led else self.now()

    def press(self, button: str) -> None:
        """Press a button: ``takeoff``, ``land``, ``stop``, ``start``."""
        now, before = self._time.now(), self._last_press
        if before is not None and before[0] == button and now - before[1] < _SAME_PRESS:
            return  # the same press came on the swarm-wide topic and on that of the drone
        self._last_press = (button, now)
        method = getattr(self.guidance, button, None)
        if method is not None and self._guard.failure is None:
            with self._guard:
                method(now)

    def _take_last_button(self, message: String) -> None:
        """Press the latest button of the flight, so that a node started in mid-flight joins it."""
        if self._last_press is None and message.data in BUTTONS:
            self.press(message.data)

    @property
    def current_pose(self) -> Pose:
        """The latest pose."""
        return self.guidance.current_pose

    # ---------------------------------------------------------------- rounds

    def _tick(self, now: float) -> None:
        self._is_led = self._is_led and self._is_led_by_poses(now)
        if not self._is_led:
            self._work()

    def _work(self) -> None:
        if not self._has_pose:
            return
        if self._guard.failure is not None:
            self._answer()
            return
        with self._guard:
            self._decide()

    def _decide(self) -> None:
        self._has_answered = False
        if not self._has_rounds:
            self._send(self.guidance.step(self._time.now()))
        elif self._in_round:
            self._try_to_finish()
        else:
            if self._statistics is not None:
                self._statistics.round_begins()
            if self._missed is not None:
                self._missed.make_up()
            self.guidance.begin_round(self._time.begin())
            self._in_round = True
            self._try_to_finish()
        if self._in_round and self._answers_early:
            self._answer()
            self._has_answered = True

    def _take_message(self) -> None:
        if self._in_round:
            self._try_to_finish()
        elif self._missed is not None:
            self._missed.look()

    def _try_to_finish(self) -> None:
        if self._in_round and self._guard.failure is None:
            with self._guard:
                now = self._time.now()
                if self.guidance.is_complete(now):
                    self._finish(now)

    def _look(self) -> None:
        if self._in_round:
            self._time.look()
            self._try_to_finish()

    def _finish(self, now: float) -> None:
        self._in_round = False
        outputs = self.guidance.finish_round(now)
        lost = frozenset(self.guidance.lost)
        if lost != self._lost:
            self._tell(lost)
        self._send(outputs)
        self._has_answered = False
        if self._missed is not None:
            self._missed.look()
        if self._statistics is not None:
            self._statistics.round_ends(now)

    def _answer(self) -> None:
        """Publish the answer to the current step, in lockstep only."""
        if self._answers is not None:
            self._answers.publish(Empty())

    def _tell(self, lost: frozenset[int]) -> None:
        for word, numbers in (("lost", lost - self._lost), ("rejoined", self._lost - lost)):
            for number in sorted(numbers):
                text = f"{word} {self.namespace_pattern.format(i=number)}"
                self._lost_publisher.publish(String(data=text))
                self.get_logger().warning(text)
        self._lost = lost

    # ---------------------------------------------------------------- out

    def _send(self, outputs: Outputs) -> None:
        reference, has_referred = outputs.reference, False
        if outputs.trajectory is not None:
            self._trajectory.publish(points_to_joint_trajectory(outputs.trajectory, self.agent_id))
        if reference is not None:
            try:
                self.reference_publisher.publish(reference_to_bytes(reference, self._kind))
                has_referred = True
            except RangeError as error:
                self.get_logger().error(f"reference not sent: {error}", throttle_duration_sec=1.0)
        idle = bool(getattr(outputs, "idle", False))
        if idle != self._idle:
            self._idle = idle
            self._idle_publisher.publish(Bool(data=idle))
        if not self._has_answered and not (has_referred and self._reference_answers):
            self._answer()
