"""The page as a node: a flight that others fly, seen and steered by topics.

`JoinedFlight` has the face of an `Experiment`, so that the page treats both alike: its drones are where odometry says,
its buttons are the topics of the table, and a round of it is a while of listening.
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

from crazychoir_fw.common.errors import CrazychoirError, MissionError, StateError, UnknownNameError
from crazychoir_fw.common.messages import Reference, TrajectoryPoint
from crazychoir_fw.flight.agent import Agent, DronePhase
from crazychoir_fw.flight.agents import (
    guidance_class,
    names_of,
    starts_of,
    takeoff_time_of,
    what_it_follows,
)
from crazychoir_fw.flight.experiment import TOUCHDOWN_M, Event, Names
from crazychoir_fw.ros.conversions import points_to_joint_trajectory
from crazychoir_fw.ros.drone_states import (
    EVENTS,
    EVENTS_QOS,
    STATES,
    STATES_QOS,
    ToldDrone,
    read_event,
    read_states,
)
from crazychoir_fw.ros.joined_drones import NEWEST, JoinedDrones
from crazychoir_fw.ros.names import BUTTONS, LATEST, REFERENCES, TRAJ_PARAMS, Topic
from crazychoir_fw.ros.node import LayerNode
from crazychoir_fw.ros.parts import layers_of_drone, one_command
from crazychoir_fw.ros.process import make_executor
from crazychoir_fw.ros.wire import bytes_to_reference

JOIN_S = 30.0
"""Longest wait for a flight that somebody else has started (s, wall)."""

_ROUND_S = 0.02  # [s], wall, of listening in a round
_TOLD_S = 3.0  # [s], wall, after which a host that says nothing of its drones is one that never does
_SETTLE_S = 2.0  # [s], wall, without anybody new, after which all are found
_SILENT_S = 10.0  # [s], wall
_HEARD_S = 10.0  # [s], wall, within which a host has heard a button
_RESUME_S = 1.0  # [s], wall
_MAX_LOGS = 2000
_WARNING = 30  # of rcl_interfaces/Log
_ALSO_EVENTS = ("lost agent", "rejoined agent", "stays where it is")  # what hosts tell as events, too
_UP_M = 0.15  # above its start, a drone flies
_NAMES = {"takeoff": "TAKE-OFF", "land": "LAND", "stop": "STOP", "start": "START"}


class JoinedFlight:
    """A flight on a ROS domain, as the page sees an `Experiment`."""

    def __init__(self, mission: Any, domain: int | None = None) -> None:
        """Make the node ``page``, which listens to a flight of a mission.

        Args:
            mission: What is flown there.
            domain: ROS domain; None is that of ``ROS_DOMAIN_ID``.

        Raises:
            MissionError: If the mission cannot be flown over ROS.
        """
        kind = one_command(mission)
        self._context = Context()
        rclpy.init(args=[], context=self._context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
        self.domain: int = self._context.get_domain_id()
        self._executor = make_executor(self._context)
        self._mission = mission
        self.agents = [_agent(mission, i) for i in range(len(mission.fleet))]
        self.groups = [] if kind == "xyz" else [_Controlled(len(self.agents), kind)]
        self.period = _ROUND_S
        self.events: list[Event] = []
        self.shares: dict[str, float] = {}
        self.node = LayerNode("page", swarm_wide=True, context=self._context)
        self._executor.add_node(self.node)
        self.backend = JoinedDrones(self.node, mission, self.close, self._spin, self._stop_now)
        self._told_wall = -np.inf
        self._presses = [0] * len(self.agents)
        self._expected: dict[int, tuple[int, float]] = {}
        """What a host will have carried out, and when it was asked (s, wall), of drones whose button was pressed."""
        self._own_presses = dict.fromkeys(BUTTONS, 0)
        self._was_stopped = self._is_silent = self._watches_topics = False
        self._idle: dict[int, bool] = {}
        self._references: dict[int, bytes] = {}
        self._logs = 0
        self._speak()
        self._listen()

    def _speak(self) -> None:
        node, count = self.node, len(self.agents)
        self._buttons = {name: node.announce(topic) for name, topic in BUTTONS.items()}
        self._button_of = {
            (name, i): node.announce(topic, node.topic_of(i, topic.name.lstrip("/")))
            for name, topic in BUTTONS.items()
            for i in range(count)
        }
        self._trajectories = [node.announce(TRAJ_PARAMS, node.topic_of(i, TRAJ_PARAMS.name)) for i in range(count)]
        self._resume = node.create_client(Trigger, "/resume")

    def _listen(self) -> None:
        node = self.node
        for name, topic in BUTTONS.items():
            node.listen(topic, lambda _, pressed=name: self._pressed(pressed))
        node.listen(_line(STATES), lambda message: self._take_states(message.data), profile=STATES_QOS)
        node.listen(_line(EVENTS), lambda message: self._take_event(message.data), profile=EVENTS_QOS)
        node.create_subscription(Log, "/rosout", self._take_log, QoSProfile(depth=100))

    # ---------------------------------------------------------------- buttons

    @property
    def time(self) -> float:
        """Time of the flight (s)."""
        return self.backend.time

    def takeoff(self, drones: Names = None) -> None:
        """Press ``/takeoff``, or that of single drones.

        Raises:
            StateError: If nobody listens.
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
        self._press("stop", drones, DronePhase.LANDED)

    def set_trajectory(self, points: Sequence[TrajectoryPoint], drones: Names = None) -> None:
        """Publish points on ``traj_params``; see `takeoff`."""
        chosen = self._chosen(drones)
        for agent in chosen:
            self._check_heard(self._trajectories[agent.index], 0)
        for agent in chosen:
            self._trajectories[agent.index].publish(points_to_joint_trajectory(points, agent.index))

    def _press(self, button: str, drones: Names, phase: DronePhase) -> None:
        chosen = self._chosen(drones)
        is_for_all = len(chosen) == len(self.agents)
        publishers = [self._buttons[button]] if is_for_all else [self._button_of[button, a.index] for a in chosen]
        for publisher in publishers:
            self._check_heard(publisher, own=int(is_for_all))
        if button == "stop":
            self._was_stopped = True
        elif phase is DronePhase.FLYING:
            self._take_up_again()
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

    def _take_up_again(self) -> None:
        """After STOP, a simulation without a host of ours takes commands only when it is asked to."""
        if not self._was_stopped or self.is_hosted:
            return
        self._was_stopped = False
        if self._resume.service_is_ready():
            asked = self._resume.call_async(Trigger.Request())
            end = wall.monotonic() + _RESUME_S
            while not asked.done() and wall.monotonic() < end:
                self._spin()

    def _stop_now(self, indices: list[int]) -> None:
        """Press STOP of drones from any thread; the flight presses it once more, and minds the answers."""
        for i in indices:
            self._button_of["stop", i].publish(Empty())

    def _spin(self) -> None:
        self._executor.spin_once(timeout_sec=0.02)

    def _chosen(self, drones: Names) -> list[Agent]:
        if drones is None:
            return list(self.agents)
        wanted = [drones] if isinstance(drones, str) else list(drones)
        known = {agent.name: agent for agent in self.agents}
        for name in wanted:
            if name not in known:
                raise UnknownNameError(f"there is no drone '{name}', allowed: {', '.join(known)}")
        return [known[name] for name in wanted]

    # ---------------------------------------------------------------- what is heard

    @property
    def is_hosted(self) -> bool:
        """Whether the host says how its drones are."""
        return wall.monotonic() - self._told_wall < _TOLD_S

    def wait_until_found(self, timeout: float, is_over: Callable[[], bool] = lambda: False) -> None:
        """Wait until the flight is heard, and its nodes hear the page.

        Args:
            timeout: Longest wait (s, wall).
            is_over: Whether nobody waits for it any more.

        Raises:
            CrazychoirError: If no flight of this mission is heard in time.
        """
        begin = wall.monotonic()
        found, since = (-1, begin)
        while not is_over():
            self.step()
            now = wall.monotonic()
            if (listeners := self._listeners()) != found:
                found, since = listeners, now
            is_told = self.is_hosted or self._is_without_host
            if is_told and found and (self._are_all_found() or now - since > _SETTLE_S):
                return
            if now - begin > timeout:
                what = "no drones of it are heard" if not is_told else "nobody listens to its buttons"
                raise CrazychoirError(
                    f"{self._mission.name}: {what} on ROS domain {self.domain} within {timeout:g} s; start the flight "
                    "(crazychoir fly MISSION.yaml --ros, or a launch file), or give its --domain"
                )

    @property
    def _is_without_host(self) -> bool:
        """Whether drones have been heard for a while, and nobody tells how they are."""
        return not self.is_hosted and wall.monotonic() - self.backend.first_wall > _TOLD_S

    def _listeners(self) -> int:
        publishers = (*self._buttons.values(), *self._button_of.values(), *self._trajectories)
        return sum(publisher.get_subscription_count() for publisher in publishers) - len(BUTTONS)

    def _are_all_found(self) -> bool:
        """Whether each guidance, and a host, listen to all buttons."""
        count = len(self.agents)
        return self.is_hosted and all(
            publisher.get_subscription_count() >= (count + 2 if publisher in self._buttons.values() else 2)
            for publisher in (*self._buttons.values(), *self._button_of.values())
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
        if self.backend.trouble is not None:
            raise MissionError(self.backend.trouble)
        if self.backend.refresh():
            self._note("again", None, "time begins anew: it is another flight")
            self._begin_anew()
        if not self.is_hosted:
            if not self._watches_topics and self._is_without_host:
                self._watch_topics()
            for agent in self.agents:
                self._guess(agent)
        self._mind_silence()

    def _begin_anew(self) -> None:
        self._expected.clear()
        self._idle.clear()
        self._references.clear()
        for agent in self.agents:
            agent.phase, agent.reference, agent.failure = DronePhase.GROUND, None, None

    def _mind_silence(self) -> None:
        is_silent = wall.monotonic() - max(self.backend.heard_wall, self._told_wall) > _SILENT_S
        if is_silent != self._is_silent and self.backend.is_heard:
            self._is_silent = self.backend.is_silent = is_silent
            sentence = f"nothing is heard of the flight for {_SILENT_S:g} s: it has ended, or it waits"
            self._note("silent" if is_silent else "heard", None, sentence if is_silent else "the flight is heard again")

    def _note(self, kind: str, drone: str | None, details: Any) -> None:
        self.events.append(Event(self.time, kind, drone, details))

    def _pressed(self, button: str) -> None:
        """A button of all drones was heard: of this page, or of somebody else."""
        if button == "stop":
            self._was_stopped = True
        if self._own_presses[button] > 0:
            self._own_presses[button] -= 1
            return
        self._note("button", None, f"{_NAMES[button]} was pressed elsewhere")
        if not self.is_hosted:
            for agent in self.agents:
                if button in ("takeoff", "start"):
                    agent.phase = DronePhase.FLYING
                elif agent.is_up:
                    agent.phase = DronePhase.LANDING if button == "land" else DronePhase.LANDED

    def _take_states(self, text: str) -> None:
        told = read_states(text)
        if set(told.drones) != {agent.name for agent in self.agents}:
            self.backend.trouble = (
                f"ROS domain {self.domain} has a flight of '{told.mission}' with {len(told.drones)} drones, and not of "
                f"'{self._mission.name}'; give its --domain, or open the page with its mission"
            )
            return
        self._told_wall = wall.monotonic()
        for agent in self.agents:
            self._take_drone(agent, told.drones[agent.name])

    def _take_drone(self, agent: Agent, told: ToldDrone) -> None:
        i = agent.index
        self._presses[i] = told.presses
        expected, asked = self._expected.get(i, (0, 0.0))
        if told.presses >= expected or wall.monotonic() - asked > _HEARD_S:
            # what was said before the host heard the button is old
            self._expected.pop(i, None)
            agent.phase = told.phase
        agent.failure = told.failure or None
        agent.reference = None if told.reference is None else Reference(position=told.reference)
        self.backend.states[i] = told.state

    def _take_event(self, text: str) -> None:
        self.events.append(Event(*read_event(text)))

    def _take_log(self, message: Log) -> None:
        """What a node logs goes to the console, but for what the host tells as an event."""
        is_told = self.is_hosted and any(words in message.msg for words in _ALSO_EVENTS)
        if message.name == self.node.get_name() or is_told or self._logs >= _MAX_LOGS:
            return
        self._logs += 1
        space = message.name.partition(".")[0]
        names = {self.node.namespace_pattern.format(i=agent.index): agent.name for agent in self.agents}
        kind = "log" if message.level < _WARNING else "warning"
        self._note(kind, names.get(space), f"{message.name}: {message.msg}")
        if self._logs == _MAX_LOGS:
            self._note("log", None, "nodes log much: the rest is on /rosout")

    # ---------------------------------------------------------------- without a host that tells

    def _watch_topics(self) -> None:
        """Listen to what guidance, planners and radio nodes say."""
        self._watches_topics = True
        node = self.node
        for agent in self.agents:
            i = agent.index
            node.create_subscription(
                Bool, node.topic_of(i, "idle"), lambda m, i=i: self._idle.update({i: m.data}), LATEST
            )
            topic = REFERENCES[what_it_follows(self._mission, i)]
            if topic.name != "acceleration":
                node.create_subscription(
                    *(topic.type, node.topic_of(i, topic.name)),
                    lambda data, i=i: self._references.update({i: data}),
                    NEWEST,
                    raw=True,
                )
            self.backend.watch_radio(i)

    def _guess(self, agent: Agent) -> None:
        """Find out the phase from height and buttons; a host that is not ours does not tell it."""
        i, height = agent.index, self.backend.poses().position[agent.index, 2] - agent.floor
        if agent.phase is DronePhase.LANDING and (height < TOUCHDOWN_M or self._idle.get(i)):
            agent.phase = DronePhase.LANDED
        elif agent.phase is DronePhase.GROUND and height > _UP_M:
            agent.phase = DronePhase.FLYING  # somebody had it take off before the page was there
        data = self._references.pop(i, None)
        if data is not None and agent.is_up:
            try:
                agent.reference = bytes_to_reference(data, what_it_follows(self._mission, i))
            except CrazychoirError as error:
                self.node.complain(agent.name, error)

    def close(self) -> None:
        """Leave the flight, which goes on."""
        self._executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self._context)


class _Controlled:
    """The controllers of all drones, somewhere else."""

    def __init__(self, count: int, kind: str) -> None:
        self.indices = np.arange(count)
        self.kind = kind


def _agent(mission: Any, i: int) -> Agent:
    """Return a drone with layers that are somewhere else: what people want to know of them is their names."""
    name = guidance_class(mission, i).__name__
    guidance = type(name, (), {"takeoff_time": takeoff_time_of(mission)})()
    planner = object() if "planning" in layers_of_drone(mission, i) else None
    agent = Agent(i, names_of(mission)[i], guidance, planner)  # type: ignore[arg-type]
    agent.begin_at(np.array(starts_of(mission)[i], float))
    return agent


def _line(name: str) -> Any:
    """Return a topic of text as a line of the table."""
    return Topic(name, String, 1, 1, "")


def join(
    mission: Any, domain: int | None = None, timeout: float = JOIN_S, is_over: Callable[[], bool] = lambda: False
) -> JoinedFlight:
    """Return a flight on a ROS domain that has been found.

    Args:
        mission: What is flown there.
        domain: ROS domain; None is that of ``ROS_DOMAIN_ID``.
        timeout: Longest wait (s, wall).
        is_over: Whether nobody waits for it any more.

    Raises:
        CrazychoirError: If no flight of this mission is heard in time.
    """
    flight = JoinedFlight(mission, domain)
    try:
        flight.wait_until_found(timeout, is_over)
    except BaseException:
        flight.close()
        raise
    return flight
