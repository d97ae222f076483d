"""A flight in other processes, watched and steered by topics, with the interface of an `Experiment` for the page.

A round spins the node for a fixed time.
"""

from __future__ import annotations

import time as wall
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import rclpy
from rcl_interfaces.msg import Log
from rclpy.context import Context
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import Bool, Empty, String
from std_srvs.srv import Trigger

from crazychoir_fw.common.errors import CrazychoirError, MissionError, StateError
from crazychoir_fw.common.messages import Pose, Reference, TrajectoryPoint
from crazychoir_fw.flight.access import DroneState
from crazychoir_fw.flight.agent import Agent, DronePhase
from crazychoir_fw.flight.agents import names_of, starts_of, what_it_follows
from crazychoir_fw.flight.event import Event
from crazychoir_fw.flight.experiment import Experiment, Names
from crazychoir_fw.flight.touchdown import TOUCHDOWN_M
from crazychoir_fw.ros.conversions import message_to_reference, points_to_joint_trajectory
from crazychoir_fw.ros.drone_states import EVENTS, EVENTS_QOS, STATES, STATES_QOS, ToldDrone, read_event, read_states
from crazychoir_fw.ros.joined_drones import NEWEST, JoinedDrones
from crazychoir_fw.ros.names import BUTTONS, LATEST, REFERENCES, TRAJ_PARAMS
from crazychoir_fw.ros.node import LayerNode
from crazychoir_fw.ros.parts import layers_of_drone, one_command
from crazychoir_fw.ros.process import make_executor
from crazychoir_fw.ros.remote import RemoteGuidance

JOIN_S = 30.0
"""Longest wait for a flight that another process has started (s, wall)."""

_ROUND_S = 0.02  # [s], wall, of listening in a round
_TOLD_S = 3.0  # [s], wall, after which a host without states counts as one that never publishes any
_SETTLE_S = 1.0  # [s], wall, without a new subscriber, after which discovery is complete
_SILENT_S = 10.0  # [s], wall
_HEARD_S = 10.0  # [s], wall: timeout of a host for a button
_MAX_LOGS = 2000
_WARNING = 30  # of rcl_interfaces/Log
_ALSO_EVENTS = ("lost agent", "rejoined agent", "stays where it is")  # what hosts publish as events, too
_UP_M = 0.15  # above its start, a drone flies
_NAMES = {"takeoff": "TAKE-OFF", "land": "LAND", "stop": "STOP", "start": "START"}


class JoinedFlight:
    """A flight on a ROS domain, as the page sees an `Experiment`."""

    def __init__(self, mission: Any, domain: int | None = None) -> None:
        """Make the node ``page``, which listens to a flight of a mission.

        Args:
            mission: The mission flown there.
            domain: ROS domain; None is that of ``ROS_DOMAIN_ID``.

        Raises:
            MissionError: If the mission cannot be flown over ROS.
        """
        kind, count = one_command(mission), len(mission.fleet)
        self._context = Context()
        rclpy.init(args=[], context=self._context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
        self.domain: int = self._context.get_domain_id()
        self._executor = make_executor(self._context)
        self._mission = mission
        self.agents = [_agent(mission, i) for i in range(count)]
        self.groups = [] if kind == "xyz" else [_Controlled(count, kind)]
        self.period = _ROUND_S
        self.events: list[Event] = []
        self.shares: dict[str, float] = {}
        self.node = node = LayerNode("page", swarm_wide=True, context=self._context)
        self._executor.add_node(node)
        self.backend = JoinedDrones(node, mission, self.close, self._spin, self._stop_now)
        self._begun_wall, self._told_wall = wall.monotonic(), -np.inf
        self._presses = [0] * count
        self._expected: dict[int, tuple[int, float]] = {}
        """By drone: the number of presses that the host must reach, and the time of the latest press (s, wall)."""
        self._own_presses = dict.fromkeys(BUTTONS, 0)
        self._was_stopped = self._is_silent = self._watches_topics = False
        self._logs, self._latest = 0, 0.0
        self._trouble: str | None = None
        self._buttons: dict[tuple[str, int | None], Any] = {}
        for name, topic in BUTTONS.items():
            for i in (None, *range(count)):
                where = topic.name if i is None else node.topic_of(i, topic.name.lstrip("/"))
                self._buttons[name, i] = node.announce(topic, where)
            node.listen(topic, lambda _, pressed=name: self._pressed(pressed))
        self._points = [node.announce(TRAJ_PARAMS, node.topic_of(i, TRAJ_PARAMS.name)) for i in range(count)]
        self._resume = node.create_client(Trigger, "/resume")
        node.create_subscription(String, STATES, self._guarded(self._take_states), STATES_QOS)
        node.create_subscription(String, EVENTS, self._guarded(self._take_event), EVENTS_QOS)
        node.create_subscription(Log, "/rosout", self._take_log, QoSProfile(depth=100))

    @property
    def time(self) -> float:
        """Time of the flight (s)."""
        return self.backend.time

    # ---------------------------------------------------------------- buttons

    def takeoff(self, drones: Names = None) -> None:
        """Press ``/takeoff``, or that of single drones.

        Raises:
            StateError: If no node subscribes to the topic.
            UnknownNameError: If there is no such drone.
        """
        self._press("takeoff", drones, DronePhase.FLYING)

    def start(self, drones: Names = None) -> None:
        """Press ``/experiment_trigger``; see `takeoff`."""
        self._press("start", drones, DronePhase.FLYING)

    def land(self, drones: Names = None) -> None:
        """Press ``/land``; see `takeoff`."""
        self._press("land", drones, DronePhase.LANDING)

    def stop(self, drones: Names = None) -> None:
        """Press ``/stop``; see `takeoff`."""
        self._press("stop", drones, DronePhase.STOPPED)

    def send_to(self, point: TrajectoryPoint, drone: str) -> None:
        """See `Experiment`; drones that follow their guidance alone cannot be sent from here."""
        self.set_trajectory([point], drone)

    def set_trajectory(self, points: Sequence[TrajectoryPoint], drones: Names = None) -> None:
        """Publish points on ``traj_params``; see `takeoff`."""
        chosen = self._chosen(drones)
        for agent in chosen:
            self._check_heard(self._points[agent.index], 0)
        for agent in chosen:
            self._points[agent.index].publish(points_to_joint_trajectory(points, agent.index))

    def _press(self, button: str, drones: Names, phase: DronePhase) -> None:
        chosen = self._chosen(drones)
        is_for_all = len(chosen) == len(self.agents)
        publishers = [self._buttons[button, i] for i in ([None] if is_for_all else [a.index for a in chosen])]
        for publisher in publishers:
            self._check_heard(publisher, own=int(is_for_all))
        if button == "stop":
            self._was_stopped = True
        elif phase is DronePhase.FLYING and self._was_stopped and not self.is_hosted:
            # after STOP, a simulation without a host takes commands only after a call of /resume
            self._was_stopped = False
            if self._resume.service_is_ready():
                self._resume.call_async(Trigger.Request())
        if is_for_all:
            self._own_presses[button] += 1
        for publisher in publishers:
            publisher.publish(Empty())
        for agent in chosen:
            expected, _ = self._expected.get(agent.index, (self._presses[agent.index], 0.0))
            self._expected[agent.index] = expected + 1, wall.monotonic()
            if phase is DronePhase.FLYING or agent.is_up:
                agent.phase = phase

    def _check_heard(self, publisher: Any, own: int) -> None:
        if publisher.get_subscription_count() <= own:
            raise StateError(f"nobody listens to {publisher.topic_name} on ROS domain {self.domain}")

    def _stop_now(self, indices: list[int]) -> None:
        """Publish STOP of drones from any thread; the flight presses it once more, and tracks the host's count."""
        for i in indices:
            self._buttons["stop", i].publish(Empty())

    def _spin(self) -> None:
        self._executor.spin_once(timeout_sec=_ROUND_S)

    _chosen = Experiment._chosen

    # ---------------------------------------------------------------- rounds

    @property
    def is_hosted(self) -> bool:
        """Whether a host publishes the states of its drones."""
        return wall.monotonic() - self._told_wall < _TOLD_S

    def wait_until_found(self, timeout: float, is_over: Callable[[], bool] = lambda: False) -> None:
        """Wait for messages of the flight, and until its nodes subscribe to the page's topics.

        Args:
            timeout: Longest wait (s, wall).
            is_over: Whether to stop waiting.

        Raises:
            CrazychoirError: If no flight of this mission is found before the timeout.
        """
        found, since = 0, self._begun_wall
        while not is_over():
            self.step()
            now = wall.monotonic()
            listeners = sum(one.get_subscription_count() for one in self._buttons.values()) - len(BUTTONS)
            if listeners != found:
                found, since = listeners, now
            is_heard = self.backend.heard_wall > 0.0
            if is_heard and found and now - since > _SETTLE_S:
                return
            if now - self._begun_wall > timeout:
                what = "nobody listens to its buttons" if is_heard else "no drones of it are heard"
                raise CrazychoirError(
                    f"{self._mission.name}: {what} on ROS domain {self.domain} within {timeout:g} s; start the flight "
                    "(crazychoir fly MISSION.yaml --ros, or a launch file), or give its --domain"
                )

    def step(self) -> None:
        """Listen for a while.

        Raises:
            CrazychoirError: If ROS was shut down, or it is a flight of another mission.
        """
        end = wall.monotonic() + _ROUND_S
        while (left := end - wall.monotonic()) > 0.0:
            if not self._context.ok():
                raise CrazychoirError("ROS was shut down")
            self._executor.spin_once(timeout_sec=left)
        if self._trouble is not None:
            raise MissionError(self._trouble)
        if self.time < self._latest - 1.0:
            self._note("again", "time begins anew: it is another flight")
            self._expected.clear()
            for agent in self.agents:
                agent.phase, agent.reference, agent.failure = DronePhase.GROUND, None, None
        self._latest = self.time
        now = wall.monotonic()
        if now - max(self._told_wall, self._begun_wall) > _TOLD_S:
            if not self._watches_topics:
                self._watch_topics()
            for agent in self.agents:
                self._guess(agent)
        is_silent = now - self.backend.heard_wall > _SILENT_S
        if is_silent is not self._is_silent and self.backend.heard_wall > 0.0:
            self._is_silent = self.backend.is_silent = is_silent
            sentence = f"nothing is heard of the flight for {_SILENT_S:g} s: it has ended, or it waits"
            self._note("silent" if is_silent else "heard", sentence if is_silent else "the flight is heard again")

    def _note(self, kind: str, text: str, drone: str | None = None) -> None:
        self.events.append(Event(self.time, kind, drone, text))

    def close(self) -> None:
        """Leave the flight, which continues."""
        self._executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self._context)

    # ---------------------------------------------------------------- what is received

    def _guarded(self, take: Callable[[str], None]) -> Callable[[String], None]:
        def guarded(message: String) -> None:
            try:
                take(message.data)
            except CrazychoirError as error:
                self.node.complain("host", error)

        return guarded

    def _pressed(self, button: str) -> None:
        """Take a swarm-wide button, pressed by this page or by another node."""
        if button == "stop":
            self._was_stopped = True
        if self._own_presses[button] > 0:
            self._own_presses[button] -= 1
            return
        self._note("button", f"{_NAMES[button]} was pressed elsewhere")
        if not self.is_hosted:
            for agent in self.agents:
                if button in ("takeoff", "start"):
                    agent.phase = DronePhase.FLYING
                elif agent.is_up:
                    agent.phase = DronePhase.LANDING if button == "land" else DronePhase.STOPPED

    def _take_states(self, text: str) -> None:
        told = read_states(text)
        if set(told.drones) != {agent.name for agent in self.agents}:
            self._trouble = (
                f"ROS domain {self.domain} has a flight of '{told.mission}' with {len(told.drones)} drones, and not of "
                f"'{self._mission.name}'; give its --domain, or open the page with its mission"
            )
            return
        self._told_wall = wall.monotonic()
        for agent in self.agents:
            self._take_drone(agent, told.drones[agent.name], told.time)

    def _take_drone(self, agent: Agent, told: ToldDrone, time: float) -> None:
        i = agent.index
        self._presses[i] = told.presses
        expected, asked = self._expected.get(i, (0, 0.0))
        if told.presses >= expected or wall.monotonic() - asked > _HEARD_S:
            # states that the host published before it received the button are stale
            self._expected.pop(i, None)
            agent.phase = told.phase
        agent.failure = told.failure or None
        agent.reference = None if told.reference is None else Reference(position=np.array(told.reference))
        self.backend.states[i] = DroneState(
            told.supervisor, told.battery_v, told.estimate_error_m, told.link, told.trouble, told.motors
        )
        place, attitude, motion = (np.array(one) for one in (told.position, told.orientation, told.velocity))
        self.backend.place(i, Pose(place, attitude, motion, time=time))

    def _take_event(self, text: str) -> None:
        self.events.append(read_event(text))

    def _take_log(self, message: Log) -> None:
        """Show log messages of nodes in the console, except those that the host publishes as events, too."""
        is_told = self.is_hosted and any(words in message.msg for words in _ALSO_EVENTS)
        if message.name == self.node.get_name() or is_told or self._logs >= _MAX_LOGS:
            return
        self._logs += 1
        space = message.name.partition(".")[0]
        names = {self.node.namespace_pattern.format(i=agent.index): agent.name for agent in self.agents}
        kind = "log" if message.level < _WARNING else "warning"
        self._note(kind, f"{message.name}: {message.msg}", names.get(space))
        if self._logs == _MAX_LOGS:
            self._note("log", "nodes log much: the rest is on /rosout")

    # ---------------------------------------------------------------- without states of a host

    def _watch_topics(self) -> None:
        """Subscribe to the topics of drones, guidance, planners and radio nodes."""
        self._watches_topics = True
        self.backend.watch_topics()
        for agent in self.agents:
            self.node.create_subscription(
                Bool, self.node.topic_of(agent.index, "idle"), self._idle_taker(agent), LATEST
            )
            kind = what_it_follows(self._mission, agent.index)
            if kind != "acceleration":
                where = self.node.topic_of(agent.index, REFERENCES[kind].name)
                self.node.listen(REFERENCES[kind], self._reference_taker(agent, kind), where, profile=NEWEST)

    def _idle_taker(self, agent: Agent) -> Callable[[Bool], None]:
        def take(message: Bool) -> None:
            if message.data and agent.phase is DronePhase.LANDING:
                agent.phase = DronePhase.LANDED

        return take

    def _reference_taker(self, agent: Agent, kind: str) -> Callable[[Any], None]:
        def take(message: Any) -> None:
            if agent.is_up:
                agent.reference = message_to_reference(message, kind)

        return take

    def _guess(self, agent: Agent) -> None:
        """Derive the phase from height and buttons, without states of a host."""
        height = self.backend.poses().position[agent.index, 2] - agent.floor
        if agent.phase is DronePhase.LANDING and height < TOUCHDOWN_M:
            agent.phase = DronePhase.LANDED
        elif agent.phase is DronePhase.GROUND and height > _UP_M:
            agent.phase = DronePhase.FLYING  # it took off before the page joined


class _Controlled:
    """The controllers of all drones, in other processes."""

    def __init__(self, count: int, kind: str) -> None:
        self.indices = np.arange(count)
        self.kind = kind


def _agent(mission: Any, i: int) -> Agent:
    """Return a drone with layers in other processes."""
    planner: Any = object() if "planning" in layers_of_drone(mission, i) else None
    agent = Agent(i, names_of(mission)[i], RemoteGuidance.of(mission, i), planner)
    agent.begin_at(np.array(starts_of(mission)[i], float))
    return agent


def join(
    mission: Any, domain: int | None = None, timeout: float = JOIN_S, is_over: Callable[[], bool] = lambda: False
) -> JoinedFlight:
    """Find a flight on a ROS domain, and return it.

    Args:
        mission: The mission flown there.
        domain: ROS domain; None is that of ``ROS_DOMAIN_ID``.
        timeout: Longest wait (s, wall).
        is_over: Whether to stop waiting.

    Raises:
        CrazychoirError: If no flight of this mission is found before the timeout.
    """
    flight = JoinedFlight(mission, domain)
    try:
        flight.wait_until_found(timeout, is_over)
    except BaseException:
        flight.close()
        raise
    return flight
