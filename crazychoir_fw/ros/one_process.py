"""A mission whose layers are the plain engine, in the process of the drones: topics are for other nodes only."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from typing import Any

from rclpy.context import Context
from std_msgs.msg import Bool, String
from trajectory_msgs.msg import JointTrajectory

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.common.messages import Pose, Reference, TrajectoryPoint, Twist
from crazychoir_fw.flight.agent import Agent
from crazychoir_fw.flight.agents import make_agents, make_groups, what_it_follows
from crazychoir_fw.flight.services import make_services
from crazychoir_fw.ros.conversions import (
    joint_trajectory_to_points,
    points_to_joint_trajectory,
    reference_to_bytes,
    twist_to_bytes,
)
from crazychoir_fw.ros.names import CMD_VEL, LATEST, REFERENCES, TRAJ_PARAMS
from crazychoir_fw.ros.parts import one_command
from crazychoir_fw.ros.simulation import Pace, SimulationNode
from crazychoir_fw.ros.statistics import EVERYBODY, STATISTICS, TELL_EVERY, told_of
from crazychoir_fw.ros.topic_experiment import TopicExperiment


class OneProcessExperiment(TopicExperiment):
    """The plain engine, bit for bit; outputs of its layers are published on topics that have a subscriber."""

    def __init__(
        self,
        mission: Any,
        backend: Any,
        executor: Any,
        pace: Pace,
        observe: Callable[[Any], None] | None = None,
        context: Context | None = None,
    ) -> None:
        """Make layers and node of a mission; arguments as of `HostedExperiment`."""
        kind, count = one_command(mission), len(mission.fleet)
        node = SimulationNode(backend, command=None, rate=mission.layers.rate, pace=pace, context=context)
        agents = make_agents(mission, lambda: backend.time, backend.true_positions)
        groups = make_groups(mission, list(backend.masses), getattr(backend, "true_poses", None))
        services = make_services(mission, agents)
        super().__init__(node, executor, mission, backend, agents, groups, observe=observe, services=services)
        self._kinds = [] if kind == "xyz" else [what_it_follows(mission, i) for i in range(count)]
        self._references = [
            node.announce(REFERENCES[follows], node.topic_of(i, REFERENCES[follows].name))
            for i, follows in enumerate(self._kinds)
        ]
        self._twists = [node.announce(CMD_VEL, node.topic_of(i, CMD_VEL.name)) for i in range(len(self._kinds))]
        self._idle = [node.create_publisher(Bool, node.topic_of(i, "idle"), LATEST) for i in range(count)]
        self._is_idle: list[bool | None] = [None] * count
        self._words = [node.create_publisher(String, node.topic_of(i, "lost_neighbors"), 10) for i in range(count)]
        self._statistics, self._tell_next = node.create_publisher(String, STATISTICS, EVERYBODY), 0.0
        self._points = [node.announce(TRAJ_PARAMS, node.topic_of(i, TRAJ_PARAMS.name)) for i in range(count)]
        self._own_points: list[list[JointTrajectory]] = [[] for _ in range(count)]
        for i in range(count):
            take = self._points_taker(agents[i])
            node.listen(TRAJ_PARAMS, take, node.topic_of(i, TRAJ_PARAMS.name))

    def step(self) -> None:
        """Fly one round, and publish the outputs of the layers."""
        super().step()
        for agent, reference in zip(self.agents, self._references, strict=False):
            if agent.is_up and reference.get_subscription_count():
                self._publish_reference(agent, reference)
        for agent in self.agents:
            is_idle = not agent.is_up
            if is_idle is not self._is_idle[agent.index]:
                self._is_idle[agent.index] = is_idle
                self._idle[agent.index].publish(Bool(data=is_idle))
        if self.time >= self._tell_next:
            self._tell_next = self.time + TELL_EVERY
            self._tell_statistics()

    def _publish_reference(self, agent: Agent, publisher: Any) -> None:
        kind, reference = self._kinds[agent.index], agent.reference
        if agent.planner is None and kind == "acceleration":
            reference = Reference(acceleration=self.accelerations[agent.index])
        try:
            publisher.publish(reference_to_bytes(reference, kind))
        except CrazychoirError as error:  # the reference lacks a field of its message
            self.node.complain(publisher.topic_name, error)

    def _tell_statistics(self) -> None:
        for agent in self.agents:
            communicator = getattr(agent.guidance, "communicator", None)
            if communicator is not None and communicator.in_neighbors + communicator.out_neighbors:
                self._statistics.publish(String(data=json.dumps(told_of(agent.index, communicator))))

    def _send(self, group: Any, indices: Any, twist: Twist) -> None:
        super()._send(group, indices, twist)
        for i, linear, angular in zip(indices, twist.linear, twist.angular, strict=True):
            if self._twists[i].get_subscription_count():
                self._guarded(self.agents[i], self._twists[i].publish, twist_to_bytes(Twist(linear, angular)))
        if self.node.latencies is not None:
            self.node.latencies += [time.perf_counter() - self.node.last_step_wall] * len(indices)

    def _plan(self, agent: Agent, points: list[TrajectoryPoint], pose: Pose, now: float) -> None:
        super()._plan(agent, points, pose, now)
        publisher = self._points[agent.index]
        if publisher.get_subscription_count() > 1:  # more than this node
            message = points_to_joint_trajectory(points, agent.index)
            self._own_points[agent.index].append(message)
            publisher.publish(message)

    def _points_taker(self, agent: Agent) -> Callable[[JointTrajectory], None]:
        own, plan = self._own_points[agent.index], super()._plan

        def take(message: JointTrajectory) -> None:
            if message in own:
                own.remove(message)
            else:
                points = joint_trajectory_to_points(message)
                plan(agent, points, self.backend.pose_of(agent.index), self.time)

        return take

    def _note_neighbors(self, agent: Agent, lost: frozenset[int]) -> None:
        for word, numbers in (("lost", lost - agent.lost), ("rejoined", agent.lost - lost)):
            for number in sorted(numbers):
                text = f"{word} {self.node.namespace_pattern.format(i=number)}"
                self._words[agent.index].publish(String(data=text))
        super()._note_neighbors(agent, lost)
