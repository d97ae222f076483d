"""A mission with layers in other processes: phases, commands, log and verdict here, outputs of layers over topics.

The flight is that of the runner in one process (`Experiment`), but guidance, planning and control of each drone
are reached by topics: odometry goes out, commands come in, round by round.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rclpy.context import Context
from std_msgs.msg import String

from crazychoir_fw.common.errors import StateError
from crazychoir_fw.common.messages import Pose, TrajectoryPoint
from crazychoir_fw.flight.agent import Agent, DronePhase
from crazychoir_fw.flight.agents import graph_of, is_only_watched, names_of, what_it_follows
from crazychoir_fw.flight.experiment import Names
from crazychoir_fw.ros.guidance_node import ANSWERED
from crazychoir_fw.ros.layer_failure import heard_failure
from crazychoir_fw.ros.names import CMD_VEL, FAILURE, LATEST, REFERENCES, TRAJ_PARAMS
from crazychoir_fw.ros.parts import Part, has_table, layers_of_drone, one_command, reference_answers
from crazychoir_fw.ros.remote import (
    RemoteGroup,
    RemoteGuidance,
    RemotePlanner,
    neighbors_taker,
    points_taker,
    reference_taker,
)
from crazychoir_fw.ros.simulation import CommandInbox, Pace, SimulationNode
from crazychoir_fw.ros.statistics import RemoteCommunicator, StatisticsCollector
from crazychoir_fw.ros.tasks import EVERYTHING, HAPPENINGS, LAST_TABLE, MEMORY
from crazychoir_fw.ros.topic_experiment import TopicExperiment

_COMMANDS = (("control", "cmd_vel"), ("avoidance", "cmd_vel"))
_COMMANDERS = ("controller", "collision_avoidance")  # nodes that answer with commands
_HOLD_S = 0.5  # [s], duration of the maneuver that stops a drone without commands
_SHORTEST_LANDING_S = 1.0
_DESCENT_SPEED = 0.4  # [m/s], of a drone that the host lands for lack of a layer
_WARM_UP_ROUNDS = 10
_WARM_UP_S = 20.0  # [s], wall, at most
_PAUSE_S = 0.3  # [s], wall: the longest round while a node has not answered yet


def names_from(reading: int) -> list[str]:
    """Return the processes that have ended since the last look, if any.

    Args:
        reading: End of a pipe that their supervisor writes their names to, one a line.
    """
    os.set_blocking(reading, False)
    try:
        return os.read(reading, 65536).decode().splitlines()
    except BlockingIOError:
        return []


class HostedExperiment(TopicExperiment):
    """An experiment whose layers are nodes."""

    def __init__(
        self,
        mission: Any,
        backend: Any,
        executor: Any,
        pace: Pace,
        observe: Any = None,
        context: Context | None = None,
    ) -> None:
        """Make the simulation node of a mission.

        Args:
            mission: The mission.
            backend: The backend of the drones.
            executor: Executor that spins the node.
            pace: How fast simulated time advances.
            observe: Called after every round.
            context: Context of rclpy.
        """
        count = len(names_of(mission))
        kind = one_command(mission)
        answers = {ANSWERED: range(count)} if pace.lockstep else {}
        if kind != "xyz":
            answers["cmd_vel"] = range(count)
        node = SimulationNode(
            backend, command=None, rate=mission.layers.rate, pace=pace, answers=answers, context=context
        )
        remote = [RemoteGuidance.of(mission, i) for i in range(count)]
        agents = []
        for i, name in enumerate(names_of(mission)):
            planner = None
            if "planning" in layers_of_drone(mission, i):
                points = node.announce(TRAJ_PARAMS, node.topic_of(i, TRAJ_PARAMS.name))
                planner = RemotePlanner(remote[i], points, i)
            agents.append(Agent(i, name, remote[i], planner, is_only_watched(mission, i)))
        self._remote = None if kind == "xyz" else RemoteGroup(CommandInbox(node, count), kind)
        groups = [] if self._remote is None else [self._remote]
        super().__init__(node, executor, mission, backend, agents, groups, observe=observe)
        self._command_timeout = mission.layers.command_timeout_s
        self._held: set[int] = set()
        self._guidance_ended: set[int] = set()  # drones whose guidance process has ended, so that no button reaches it
        self._parts: dict[str, Part] = {}
        self._look_for_deaths: Callable[[], None] = lambda: None
        self._listen(mission, remote, kind)
        self._statistics = self._collector(mission, remote)

    def _listen(self, mission: Any, remote: Sequence[RemoteGuidance], kind: str) -> None:
        node = self.node
        if has_table(mission):
            node.create_subscription(String, HAPPENINGS, self._hear_of, EVERYTHING)
            # outlives the process of the table
            self._last_table = node.create_publisher(String, LAST_TABLE, LATEST)
            node.create_subscription(String, MEMORY, self._last_table.publish, LATEST)
        numbers = {node.namespace_pattern.format(i=i): i for i in range(len(remote))}
        for i, guidance in enumerate(remote):
            node.create_subscription(String, node.topic_of(i, "lost_neighbors"), neighbors_taker(guidance, numbers), 10)
            node.create_subscription(String, node.topic_of(i, FAILURE), partial(self._layer_failed, i), LATEST)
            if kind == "xyz":
                node.listen(TRAJ_PARAMS, points_taker(guidance), node.topic_of(i, "traj_params"))
                continue
            follows = what_it_follows(mission, i)
            topic = REFERENCES[follows]
            take = reference_taker(guidance, follows)
            if node.pace.lockstep and reference_answers(mission, i):
                take = self._answered_by(take, i)
            node.listen(topic, take, node.topic_of(i, topic.name), fast=True)

    def _answered_by(self, take: Callable[[Any], None], i: int) -> Callable[[Any], None]:
        def take_and_answer(message: Any) -> None:
            take(message)
            self.node.answer((i, ANSWERED))

        return take_and_answer

    def _collector(self, mission: Any, remote: Sequence[RemoteGuidance]) -> StatisticsCollector:
        graph = graph_of(mission)
        for i, guidance in enumerate(remote):
            if graph.in_neighbors(i) or graph.out_neighbors(i):
                guidance.communicator = RemoteCommunicator(graph.in_neighbors(i), graph.out_neighbors(i))
        communicators = {i: one.communicator for i, one in enumerate(remote) if one.communicator is not None}
        return StatisticsCollector(self.node, communicators)

    def communication(self) -> dict[str, Any] | None:
        """See `Experiment`; queries the live processes, and uses the latest statistics of those that have ended."""
        alive = [agent.index for agent in self.agents if agent.index not in self._guidance_ended]
        self._statistics.ask(alive, lambda: self._executor.spin_once(timeout_sec=0.05))
        return super().communication()

    def _hear_of(self, message: String) -> None:
        """Record an event of a table as an event of the flight."""
        try:
            told = json.loads(message.data)
            agent = told["agent"]
            if agent is None or 0 <= int(agent) < len(self.agents):
                self._note_of_service(str(told["kind"]), agent, dict(told["details"]))
        except (ValueError, KeyError, TypeError) as error:
            self.node.get_logger().warning(f"{HAPPENINGS}: {error}", throttle_duration_sec=1.0)

    # ---------------------------------------------------------------- buttons

    def _carry_out(self, button: str, drones: Names) -> None:
        if button in ("takeoff", "start"):
            self._hear_again(drones)
        super()._carry_out(button, drones)
        if button == "land" and not self.backend.is_real_time:
            for agent in self._chosen(drones):
                unheard = () if self._remote is None else self._remote.unheard
                if agent.index in self._held or agent.index in self._guidance_ended or agent.index in unheard:
                    self._bring_down(agent)

    def cannot_divert(self, agent: Agent) -> str | None:
        """See `Experiment`: its controller is another process, and follows its guidance."""
        if self.backend.is_real_time or self._remote is None:
            return (
                f"{agent.name}: follows its guidance, which is another process; over the radio it can be sent "
                "with --processes one only"
            )
        return None

    def _divert(self, agent: Agent, point: TrajectoryPoint) -> None:
        if reason := self.cannot_divert(agent):
            raise StateError(reason)
        if agent.is_up and agent.failure is None and self._remote is not None:
            self._remote.unheard.add(agent.index)
            self._guarded(agent, self.backend.go_to, agent.index, point)

    def _hear_again(self, drones: Names) -> None:
        if self._remote is not None:
            self._remote.unheard.difference_update(agent.index for agent in self._chosen(drones))

    # ---------------------------------------------------------------- rounds

    def watch_deaths(self, reading: int, parts: Sequence[Part]) -> None:
        """Watch for processes that end, and drop their nodes from the lockstep.

        Args:
            reading: See `names_from`.
            parts: The layers of each process.
        """
        self._parts = {part.name: part for part in parts}

        def look() -> None:
            for name in names_from(reading):
                if name in self._parts:
                    self._has_ended(self._parts[name])

        self.node.while_waiting = self._look_for_deaths = look

    def _has_ended(self, part: Part) -> None:
        """Drop a process that has ended from the lockstep, and log it."""
        for i in part.agents:
            for layer, topic in (("guidance", ANSWERED), *_COMMANDS):
                if layer in part.layers:
                    self.node.answers.bury((i, topic))
            if "guidance" in part.layers:
                self._guidance_ended.add(i)
                if self.agents[i].phase is DronePhase.LANDING and not self.backend.is_real_time:
                    self._bring_down(self.agents[i])
        self._note_of_service(
            "ended", part.agents[0] if len(part.agents) == 1 else None, f"process {part.name} has ended"
        )

    def _layer_failed(self, i: int, message: String) -> None:
        """Land a drone with a layer that has raised, and drop its commands from the lockstep."""
        agent = self.agents[i]
        node, reason = heard_failure(message)
        if node in _COMMANDERS:
            self.node.answers.bury((i, CMD_VEL.name))
        self._let_down(agent, f"{agent.name}: {reason} (at {self.time:.2f} s)")

    def _is_ready(self, process: str) -> None:
        super()._is_ready(process)
        part = self._parts.get(process)
        if part is not None and "guidance" in part.layers:
            self._guidance_ended.difference_update(part.agents)
            if self._remote is not None:
                self._remote.unheard.difference_update(part.agents)

    def warm_up(self) -> None:
        """Publish time and poses for a few rounds while the drones rest, so that every node receives them.

        Afterwards each step waits for all nodes. The number of rounds is fixed, so that flights are reproducible.
        """
        answers, deadline = self.node.answers, time.monotonic() + _WARM_UP_S
        # the time comes first, so that no node takes the first pose for a stale one
        self.node.publish_clock()
        pause = time.monotonic() + _PAUSE_S
        while time.monotonic() < pause:
            self._executor.spin_once(timeout_sec=0.05)
        for _ in range(_WARM_UP_ROUNDS):
            self.node.publish()
            pause = time.monotonic() + (_PAUSE_S if self.node.pace.lockstep else 0.0)
            while time.monotonic() < pause or (not answers.is_complete and time.monotonic() < deadline):
                self._executor.spin_once(timeout_sec=0.01)
                if not answers.missing and answers.is_complete:
                    break
            self.backend.advance(self.period)
        if self.node.pace.lockstep:
            answers.expect_all()

    def _decide(self, agents: Sequence[Agent], poses: Pose, now: float) -> None:
        """Take the outputs received from guidance processes since the last round."""
        for agent in agents:
            guidance: RemoteGuidance = agent.guidance
            if guidance.is_new or guidance.lost is not agent.lost:
                guidance.is_new = not agent.is_up  # a resting drone takes no reference, so the reference stays new
                self._take(agent, guidance.step(now), poses, now)

    def step(self) -> None:
        """See `TopicExperiment`."""
        # without lockstep there is no wait, and `while_waiting` is not called
        self._look_for_deaths()
        super().step()
        if self._remote is not None and not self.backend.is_real_time:
            self._hold_whom_nobody_commands(self._remote.commanded)

    def _hold_whom_nobody_commands(self, commanded: NDArray[np.float64]) -> None:
        """Hold drones in place by their onboard planner once their latest command is older than the timeout.

        Over the radio the handler has this timeout; simulated drones would fall, or keep their last command.
        """
        now = self.time
        for agent in self.agents:
            i = agent.index
            is_ours = agent.failure is not None or self._remote is None or i in self._remote.unheard
            if now - commanded[i] <= self._command_timeout or not agent.is_up or is_ours:
                self._held.discard(i)
            elif i not in self._held:
                self._held.add(i)
                sentence = f"no command for {self._command_timeout:g} s, stays where it is"
                self.node.get_logger().warning(f"{agent.name}: {sentence}")
                self._note("held", agent, sentence)
                if agent.phase is DronePhase.LANDING:
                    self._bring_down(agent)
                else:
                    self._guarded(
                        agent, self.backend.go_to, i, TrajectoryPoint(_HOLD_S, self.backend.pose_of(i).position)
                    )

    def _bring_down(self, agent: Agent) -> None:
        """Land a drone by its onboard planner, when no layer lands it."""
        if not agent.is_up or agent.failure is not None:
            return
        if self._remote is not None:
            self._remote.unheard.add(agent.index)
        x, y, z = self.backend.pose_of(agent.index).position
        duration = max(_SHORTEST_LANDING_S, (z - agent.floor) / _DESCENT_SPEED)
        self._guarded(agent, self.backend.go_to, agent.index, TrajectoryPoint(duration, np.array([x, y, agent.floor])))
