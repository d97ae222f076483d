"""Guidance as ROS 2 nodes, with the class names and arguments of the paper's listings.

A round is never waited for in a callback: it begins with a pose, messages of neighbors come in as they come, and
whichever completes it lets the node decide. A round whose messages do not come ends at its deadline: by the clock of
ROS, and also by the clock on the wall, since simulated time may stand still while a simulation waits for this node.

Who is silent is told on ``lost_neighbors`` (`std_msgs/String`, "lost agent_3", "rejoined agent_3") and to the log.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from rclpy.clock import Clock, ClockType
from rclpy.context import Context
from rclpy.serialization import serialize_message
from std_msgs.msg import Bool, Empty, String

from crazychoir_fw import guidance as plain
from crazychoir_fw.errors import RangeError
from crazychoir_fw.guidance import Outputs, TimeVaryingCommunicator
from crazychoir_fw.messages import Pose, Reference
from crazychoir_fw.ros.communicator import RosTransport
from crazychoir_fw.ros.conversions import points_to_joint_trajectory
from crazychoir_fw.ros.hub import Hub
from crazychoir_fw.ros.names import BUTTONS, LAST_BUTTON, LATEST, ODOM, REFERENCES, TRAJ_PARAMS
from crazychoir_fw.ros.node import LayerNode
from crazychoir_fw.ros.outlet import Outlet
from crazychoir_fw.ros.pose_sources import pose_subscribe
from crazychoir_fw.ros.stalling import StallingClock
from crazychoir_fw.ros.wire import EMPTY, reference_bytes

_CLOSE = 1.5  # periods between poses, for which each pose makes a step
_SAME_PRESS = 0.05  # [s]
_LOOK_EVERY = 0.05  # [s], wall: at rounds that wait

if TYPE_CHECKING:
    from crazychoir_fw.ros.teams import GuidanceTeam

Build = Callable[["GuidanceNode"], Any]
"""Makes the plain guidance of a node, once its parameters and topics are there."""


class GuidanceNode(LayerNode):
    """Wires a guidance to topics: pose and buttons in, references and trajectories out.

    The names below derive from it. Whoever has a plain guidance, hands a function that makes it to `build`.
    """

    stage = 0

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
        hub: Hub | None = None,
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
            hub: What it shares with other nodes of its process.
        """
        super().__init__(node_name, agent_id=agent_id, parameters=parameters, context=context, hub=hub)
        self.update_frequency = update_frequency
        self.patience: float = self.declare(
            "patience", 0.5, "longest wait for neighbors in a round (s, wall clock)", low=0.001, high=60.0
        )
        self._answers = None
        if self.declare("lockstep", False, "whether each tick is answered on the topic answered"):
            self._answers = Outlet(self.create_publisher(Empty, "answered", 10), self.hub)
        self.transport: RosTransport | None = None
        """Topics of its communicator, if it has one."""
        self.guidance: Any = build(self)
        """The plain guidance."""
        # otherwise its rounds last over many steps, and no step waits for one
        is_paced = getattr(self.guidance, "is_paced_by_rounds", True)
        self._has_rounds = hasattr(self.guidance, "begin_round") and is_paced
        self._in_round = False
        self._pose_time, self._pose_step, self._is_led = -math.inf, math.inf, False
        self._time = StallingClock(self._latest_time, self.patience)
        self._lost: frozenset[int] = frozenset()
        self._idle: bool | None = None
        self._has_pose = False
        self.team: GuidanceTeam | None = None
        """With whom it decides together."""
        kind = getattr(self.guidance, "kind", "acceleration")
        self._kind = kind
        self._encode_reference = partial(reference_bytes, kind=kind)
        self._reference = self.outlet(REFERENCES[kind], input_topic)
        self._trajectory = self.outlet(TRAJ_PARAMS)
        self._idle_publisher = self.create_publisher(Bool, "idle", LATEST)
        self.pose_source = pose_subscribe(pose_handler, pose_topic, self, self._take_pose, pose_callback)
        for other in getattr(self.guidance, "watched", ()):
            topic = self.topic_of(other, ODOM.name)
            pose_subscribe("pubsub", topic, self, lambda pose, j=other: self.guidance.see(j, pose))
        self._last_press: tuple[str, float] | None = None
        for name, topic in BUTTONS.items():
            # all drones at once, or this one alone
            for where in (topic.name, topic.name.lstrip("/")):
                self.listen(topic, lambda _, pressed=name: self.press(pressed), where)
        for where in (f"/{LAST_BUTTON}", LAST_BUTTON):
            self.create_subscription(String, where, self._take_last_button, LATEST)
        if self._has_rounds:
            self._lost_publisher = self.create_publisher(String, "lost_neighbors", 10)
            if self.hub is None:
                self.create_timer(_LOOK_EVERY, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))
            else:
                self.hub.when_looking(self._look)
                self.hub.when_settling(self, self._try_to_finish, lambda: self._in_round)
        if self.transport is not None:
            self.transport.when_received.append(self._try_to_finish)
        self.every(update_frequency, self._tick)

    # ---------------------------------------------------------------- in

    def _take_pose(self, pose: Pose) -> None:
        self._has_pose = pose.position is not None
        self.guidance.set_pose(pose)
        if pose.time is None or pose.time == self._pose_time:
            return
        self._pose_step, self._pose_time = pose.time - self._pose_time, pose.time
        self._is_led = self.is_simulated_time and self._is_led_by_poses(pose.time)
        if self._is_led:
            self._work()

    def _is_led_by_poses(self, now: float) -> bool:
        """Whether simulated poses come so often, up to now, that each of them makes a step.

        Then results do not depend on which of pose and clock comes first.
        """
        limit = _CLOSE / self.update_frequency
        return 0.0 < self._pose_step <= limit and now - self._pose_time <= limit

    def _latest_time(self) -> float:
        """Return the time (s): that of the newest pose where simulated poses lead."""
        if self.hub is not None:
            return max(self.hub.now, self._pose_time) if self._is_led else self.hub.now
        # asking the clock of a node takes 20 µs
        return self._pose_time if self._is_led else self.now()

    def press(self, button: str) -> None:
        """Press a button: ``takeoff``, ``land``, ``stop``, ``start``."""
        now, before = self._time.now(), self._last_press
        if before is not None and before[0] == button and now - before[1] < _SAME_PRESS:
            return  # it was heard both ways
        self._last_press = (button, now)
        if self.team is not None:
            self.team.tell_poses()
        method = getattr(self.guidance, button, None)
        if method is not None:
            method(now)

    def _take_last_button(self, message: String) -> None:
        """Who was started in the middle of a flight, joins it."""
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
        if not self._has_rounds:
            self._send(self.guidance.step(self._time.now()))
        elif self._in_round:
            self._try_to_finish()
        else:
            self.guidance.begin_round(self._time.begin())
            self._in_round = True
            if self.hub is None or not self.hub.is_working:
                self._try_to_finish()

    def _try_to_finish(self) -> None:
        if self._in_round:
            now = self._time.now()
            if self.guidance.is_complete(now):
                self._finish(now)

    def _look(self) -> None:
        if self._in_round:
            self._time.look()
            self._try_to_finish()

    def _finish(self, now: float) -> None:
        self._in_round = False
        self.take_outputs(self.guidance.finish_round(now))

    # ---------------------------------------------------------------- in a team

    @property
    def row(self) -> int | None:
        """Which row of a bundle of odometry is its own, if it takes its poses from there."""
        return None if self.hub is None else self.hub.row_of(self)

    @property
    def may_work_in_team(self) -> bool:
        """Whether its rounds are nobody's business but the team's."""
        return not (self._in_round or self._time.has_waited or (self.transport and self.transport.is_heard_outside))

    def note_pose(self, pose: Pose) -> None:
        """Take a pose that begins no round."""
        self._has_pose = True
        self._pose_time = pose.time
        self.guidance.set_pose(pose)

    def ask_for(self, reference: Reference) -> None:
        """Say a reference."""
        self._reference.say(reference, self._encode_reference)

    def answer(self) -> None:
        """Answer the step, in lockstep."""
        if self._answers is not None:
            self._answers.say(None, _empty)

    def take_outputs(self, outputs: Outputs) -> None:
        """Say what the guidance asks for at the end of a round."""
        lost = frozenset(self.guidance.lost)
        if lost != self._lost:
            self._tell(lost)
        self._send(outputs)

    def _tell(self, lost: frozenset[int]) -> None:
        for word, numbers in (("lost", lost - self._lost), ("rejoined", self._lost - lost)):
            for number in sorted(numbers):
                text = f"{word} {self.namespace_pattern.format(i=number)}"
                self._lost_publisher.publish(String(data=text))
                self.get_logger().warning(text)
        self._lost = lost

    # ---------------------------------------------------------------- out

    def _send(self, outputs: Outputs) -> None:
        reference = outputs.reference
        if outputs.trajectory is not None:
            self._trajectory.say(outputs.trajectory, self._encode_points)
        if reference is not None:
            numbers = getattr(reference, self._kind, None)
            if numbers is None or math.isfinite(numbers.sum()):
                self.ask_for(reference)
            else:
                text = f"asks for the {self._kind} {numbers}: not sent"
                self.get_logger().error(text, throttle_duration_sec=1.0)
        idle = bool(getattr(outputs, "idle", False))
        if idle != self._idle:
            self._idle = idle
            self._idle_publisher.publish(Bool(data=idle))
        self.answer()

    def _encode_points(self, points: Any) -> bytes:
        return bytes(serialize_message(points_to_joint_trajectory(points, self.agent_id)))

    # ---------------------------------------------------------------- for those who build

    def declare_start(self) -> list[float] | None:
        """Declare ``init_pos`` and return it."""
        return self.declare(
            "init_pos", None, "start position (m, world); by default the first pose", list[float], length=3
        )

    def declare_communicator(self, kind: type = TimeVaryingCommunicator, **options: Any) -> Any:
        """Declare ``N``, ``in_neigh`` and ``out_neigh``, and return a communicator over topics."""
        size = self.declare("N", 1, "number of agents", low=1)
        heard = self.declare("in_neigh", [], "neighbors that this agent hears", list[int], low=0, high=size - 1)
        hearers = self.declare("out_neigh", heard, "neighbors that hear this agent", list[int], low=0, high=size - 1)
        return self.make_communicator(size, heard or [], hearers or [], kind, **options)

    def make_communicator(
        self,
        size: int,
        heard: list[int],
        hearers: list[int],
        kind: type = TimeVaryingCommunicator,
        disturb: Callable[[Any], Any] | None = None,
        **options: Any,
    ) -> Any:
        """Return a communicator over topics of this node; `disturb` makes of its transport what is to be used."""
        self.make_transport(kind.reliable)
        transport = self.transport if disturb is None else disturb(self.transport)
        topic = self.namespace_pattern.replace("{i}", "{agent}") + "/communicator"
        options.setdefault("clock", time.monotonic)
        return kind(self.agent_id, size, heard, hearers, transport=transport, topic=topic, **options)

    def make_transport(self, reliable: bool = True) -> RosTransport:
        """Return topics of this node as a transport."""
        self.transport = RosTransport(self, reliable=reliable)
        return self.transport

    @property
    def is_connected(self) -> bool:
        """Whether somebody is at the other end of all topics of its communicator."""
        return self.transport is None or self.transport.is_connected


def _empty(_: None) -> bytes:
    return EMPTY


class CFGuidance(GuidanceNode):
    """Take-off and landing, and nothing in between."""

    def __init__(
        self,
        pose_handler: str | None = "pubsub",
        pose_topic: str | None = "odom",
        pose_callback: Callable[[], None] | None = None,
        takeoff_time: float = 5.0,
        height: float = 1.0,
        *,
        update_frequency: float = 100.0,
        node_name: str = "guidance",
        **options: Any,
    ) -> None:
        """Make the node; parameter ``init_pos``.

        Args:
            pose_handler: Where poses come from.
            pose_topic: Topic of the pose.
            pose_callback: Called after each pose.
            takeoff_time: How long take-off and landing last (s).
            height: Height of the take-off (m).
            update_frequency: Steps per second (Hz).
            node_name: Name of the node.
            options: Of `GuidanceNode`.
        """

        def build(node: GuidanceNode) -> Any:
            return self._plain(
                agent_id=node.agent_id,
                init_pos=node.declare_start(),
                takeoff_time=takeoff_time,
                height=height,
                update_frequency=update_frequency,
            )

        super().__init__(
            build,
            node_name=node_name,
            update_frequency=update_frequency,
            pose_handler=pose_handler,
            pose_topic=pose_topic,
            pose_callback=pose_callback,
            **options,
        )

    _plain: Any = staticmethod(plain.CFGuidance)


class SimpleGuidance(CFGuidance):
    """Take-off and landing as go-tos on ``traj_params``."""

    _plain: Any = staticmethod(plain.SimpleGuidance)

    def __init__(self, *args: Any, node_name: str = "simple_guidance", **options: Any) -> None:
        """Make the node; arguments as of `CFGuidance`."""
        super().__init__(*args, node_name=node_name, **options)


class GoToGuidance(GuidanceNode):
    """A list of go-tos, one after the other, from the button start on."""

    def __init__(
        self,
        pose_handler: str | None = "pubsub",
        pose_topic: str | None = "odom",
        pose_callback: Callable[[], None] | None = None,
        takeoff_time: float = 5.0,
        *,
        update_frequency: float = 100.0,
        **options: Any,
    ) -> None:
        """Make the node; parameters ``N``, ``init_pos``, ``goals``: t, x, y, z, t, x, y, z, … (s, m)."""

        def build(node: GuidanceNode) -> Any:
            node.declare("N", 1, "number of agents", low=1)
            flat = node.declare("goals", [], "goals: t, x, y, z of each (s; m, world)", list[float]) or []
            if len(flat) % 4:
                raise RangeError(
                    f"{node.get_fully_qualified_name()}: goals has {len(flat)} numbers, allowed: 4 per goal"
                )
            goals = [tuple(flat[k : k + 4]) for k in range(0, len(flat), 4)]
            return plain.GoToGuidance(
                agent_id=node.agent_id,
                init_pos=node.declare_start(),
                takeoff_time=takeoff_time,
                goals=goals,
                update_frequency=update_frequency,
            )

        super().__init__(
            build,
            node_name="goto_guidance",
            update_frequency=update_frequency,
            pose_handler=pose_handler,
            pose_topic=pose_topic,
            pose_callback=pose_callback,
            **options,
        )


class CFDistributedFeedback(GuidanceNode):
    """Feedback from the poses of neighbors: override `evaluate_input`."""

    def __init__(
        self,
        update_frequency: float = 100.0,
        pose_handler: str | None = "pubsub",
        pose_topic: str | None = "odom",
        pose_callback: Callable[[], None] | None = None,
        input_topic: str = "acceleration",
        **options: Any,
    ) -> None:
        """Make the node; parameters ``N``, ``in_neigh``, ``out_neigh``, ``init_pos``, ``weights``.

        Args:
            update_frequency: Rounds per second (Hz).
            pose_handler: Where poses come from.
            pose_topic: Topic of the pose.
            pose_callback: Called after each pose.
            input_topic: Where the acceleration goes.
            options: Of `GuidanceNode`.
        """
        super().__init__(
            self._build,
            update_frequency=update_frequency,
            pose_handler=pose_handler,
            pose_topic=pose_topic,
            pose_callback=pose_callback,
            input_topic=input_topic,
            **options,
        )

    def _build(self, node: GuidanceNode) -> Any:
        self.weights = self.declare("weights", None, "weights of the neighbors", list[float])
        law = _feedback_of(self)
        return law(
            self.agent_id,
            self.declare_communicator(),
            init_pos=self.declare_start(),
            update_frequency=self._frequency_of(node),
        )

    def _frequency_of(self, node: GuidanceNode) -> float:
        return node.update_frequency

    def evaluate_input(self, neigh_data: dict[int, Pose]) -> NDArray[np.float64]:
        """Return the acceleration (m/s^2, world), shape (3,), given the poses of neighbors."""
        raise NotImplementedError


def _feedback_of(node: CFDistributedFeedback) -> type:
    class Feedback(plain.CFDistributedFeedback):
        def evaluate_input(self, neigh_data: dict[int, Pose]) -> NDArray[np.float64]:
            return node.evaluate_input(neigh_data)

    return Feedback


class BearingFormation(CFDistributedFeedback):
    """The paper's bearing-based formation."""

    def __init__(
        self,
        update_frequency: float = 100.0,
        pose_handler: str | None = "pubsub",
        pose_topic: str | None = "odom",
        pose_callback: Callable[[], None] | None = None,
        input_topic: str = "acceleration",
        *,
        gains: Any = None,
        height: float = 1.0,
        takeoff_time: float = 5.0,
        **options: Any,
    ) -> None:
        """Make the node; parameters of `CFDistributedFeedback`, and ``is_leader``, ``dd``, ``ort_proj``, ``vicon``.

        Args:
            update_frequency: Rounds per second (Hz).
            pose_handler: Where poses come from.
            pose_topic: Topic of the pose.
            pose_callback: Called after each pose.
            input_topic: Where the acceleration goes.
            gains: Set of gains, by name or as a dataclass; None: ``vicon`` if that parameter is set, else ``webots``.
            height: Height of the take-off (m).
            takeoff_time: How long the take-off lasts (s).
            options: Of `GuidanceNode`.
        """
        self._gains, self._height, self._takeoff_time = gains, height, takeoff_time
        super().__init__(update_frequency, pose_handler, pose_topic, pose_callback, input_topic, **options)

    def _build(self, node: GuidanceNode) -> Any:
        communicator = self.declare_communicator()
        size = communicator.size
        leads = self.declare("is_leader", False, "whether it follows its own trajectory and not the formation")
        flat = self.declare("ort_proj", None, "rows of projections, 3 x 3 N, by rows", list[float], length=9 * size)
        self.declare("dd", None, "spatial dimension, for compatibility: always 3", int)
        vicon = self.declare("vicon", False, "whether the gains are those for motion capture")
        return plain.BearingFormation(
            self.agent_id,
            communicator,
            init_pos=self.declare_start(),
            update_frequency=self._frequency_of(node),
            is_leader=leads,
            ort_proj=None if flat is None else np.reshape(flat, (3, 3 * size)),
            gains=self._gains or ("vicon" if vicon else "webots"),
            height=self._height,
            takeoff_time=self._takeoff_time,
        )

    def evaluate_input(self, neigh_data: dict[int, Pose]) -> NDArray[np.float64]:
        """Return the acceleration (m/s^2, world), shape (3,), given the poses of neighbors."""
        return self.guidance.evaluate_input(neigh_data)
