"""The layers of a mission as nodes: any of them, of any drones, in this process."""

from __future__ import annotations

import signal
import time
from collections.abc import Sequence
from functools import partial
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import String

from crazychoir_fw.experiment import agents
from crazychoir_fw.experiment.communicators import disturbed
from crazychoir_fw.guidance import TimeVaryingCommunicator
from crazychoir_fw.ros.communicator import RosTransport
from crazychoir_fw.ros.controller import CrazyflieController
from crazychoir_fw.ros.guidance import GuidanceNode
from crazychoir_fw.ros.hosting import ANSWERED, READY
from crazychoir_fw.ros.names import LATEST
from crazychoir_fw.ros.parts import Part, layers_of_drone
from crazychoir_fw.ros.trajectory import TrajectoryHandler

_LOOK_EVERY = 0.05  # [s], wall: whether all partners are there
_TRAFFIC = ("odom", "cmd_vel", "acceleration", "position", "fullstate", "answered", "clock")


def make_nodes(mission: Any, part: Part, lockstep: bool, patience: float, context: Context | None = None) -> list[Node]:
    """Return the nodes of a part.

    Args:
        mission: The mission.
        part: Which of its layers.
        lockstep: Whether guidance answers each tick.
        patience: How long a guidance waits for neighbors while simulated time stands still (s, wall).
        context: Context of rclpy.

    Raises:
        CrazychoirError: If a layer cannot be made as the mission says.
    """
    nodes: list[Node] = []
    for i in part.agents:
        common: dict[str, Any] = {"agent_id": i, "parameters": {"use_sim_time": True}, "context": context}
        for layer in layers_of_drone(mission, i):
            if layer not in part.layers:
                continue
            if layer == "guidance":
                nodes.append(_guidance(mission, i, lockstep, patience, context))
            elif layer == "planning":
                nodes.append(TrajectoryHandler(handler=agents.make_trajectory_handler(mission, i), **common))
            else:
                nodes.append(CrazyflieController(controller=agents.make_controller(mission, i), **common))
    return nodes


def _guidance(mission: Any, i: int, lockstep: bool, patience: float, context: Context | None) -> GuidanceNode:
    graph, settings = agents.graph_of(mission), mission.layers.communication_of(mission.fleet[i].id)

    schedule = agents.schedule_of(mission)

    def build(node: GuidanceNode) -> Any:
        communicator = None
        if graph.in_neighbors(i) or graph.out_neighbors(i):
            communicator = node.make_communicator(
                graph.size,
                graph.in_neighbors(i),
                graph.out_neighbors(i),
                TimeVaryingCommunicator,
                synchronous_mode=settings.mode == "lockstep",
                differentiated_topics=settings.differentiated_topics,
                deadline=settings.deadline_s,
                clock=node.now,
                schedule=schedule,
                disturb=partial(disturbed, mission, i, clock=node.now),
            )
        else:
            # nobody will ever be at the other end: not the transport whose partners the node waits for
            communicator = TimeVaryingCommunicator(i, graph.size, [], [], transport=RosTransport(node))
        return agents.make_guidance(mission, i, communicator, schedule)

    parameters = {"use_sim_time": True, "lockstep": lockstep, "patience": patience}
    return GuidanceNode(
        build, update_frequency=float(mission.layers.rate), agent_id=i, parameters=parameters, context=context
    )


def run_part(mission: Any, part: Part, lockstep: bool = True, patience: float = 0.5) -> int:
    """Be a process of a mission until ROS is shut down.

    Args:
        mission: The mission.
        part: What this process does.
        lockstep: Whether guidance answers each tick.
        patience: See `make_nodes`.

    Returns:
        The exit code.
    """
    context = Context()
    rclpy.init(args=[], context=context, signal_handler_options=SignalHandlerOptions.NO)
    for sign in (signal.SIGINT, signal.SIGTERM):
        # an exception in the middle of a callback would be told as its failure
        signal.signal(sign, lambda *_: context.try_shutdown())
    try:
        executor = make_executor(context)
        nodes = make_nodes(mission, part, lockstep, patience, context)
        for node in nodes:
            executor.add_node(node)
        spin(executor, nodes, part.name, context)
    except ExternalShutdownException:
        pass
    finally:
        rclpy.try_shutdown(context=context)
    return 0


def make_executor(context: Context) -> Any:
    """Return the fastest executor that there is: events instead of wait sets cost a fifth per message."""
    try:
        from rclpy.experimental import EventsExecutor
    except ImportError:  # before Jazzy's patch 4, and in Humble
        from rclpy.executors import SingleThreadedExecutor

        return SingleThreadedExecutor(context=context)
    return EventsExecutor(context=context)


def spin(executor: Any, nodes: Sequence[Node], name: str, context: Context) -> None:
    """Work on messages, and say when all partners are there."""
    if not nodes:
        return
    announcer = nodes[0].create_publisher(String, READY, LATEST)
    is_ready = False
    looked = 0.0
    while context.ok():
        executor.spin_once(timeout_sec=0.1 if is_ready else _LOOK_EVERY)
        if not is_ready and time.monotonic() - looked > _LOOK_EVERY:
            looked = time.monotonic()
            if all(is_connected(node) for node in nodes):
                is_ready = True
                announcer.publish(String(data=name))


def is_connected(node: Node) -> bool:
    """Whether somebody is at the other end of the topics that a node needs at every step."""
    if isinstance(node, GuidanceNode) and not node.is_connected:
        return False
    for publisher in node.publishers:
        name = publisher.topic_name.rpartition("/")[2]
        if name in ("cmd_vel", ANSWERED) and not publisher.get_subscription_count():
            return False
    for subscription in node.subscriptions:
        name = subscription.topic_name.rpartition("/")[2]
        if name in _TRAFFIC and not subscription.get_publisher_count():
            return False
    return True
