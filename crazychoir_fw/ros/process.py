"""The layers of a mission as nodes: any of them, of any drones, in this process."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from functools import partial
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from std_msgs.msg import String

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.flight import agents
from crazychoir_fw.flight.services import make_table
from crazychoir_fw.guidance import TimeVaryingCommunicator
from crazychoir_fw.mission.communicators import disturbed, goes_by_distance
from crazychoir_fw.ros.communicator import RosTransport
from crazychoir_fw.ros.guidance_node import ANSWERED, GuidanceNode
from crazychoir_fw.ros.names import CLOCK, LATEST
from crazychoir_fw.ros.parts import SENSING, TABLE, Part, has_table, layers_of_drone, reference_answers
from crazychoir_fw.ros.pose_cache import PoseCache
from crazychoir_fw.ros.safety_parts import make_avoidance_node, make_control_node, make_sensing_node
from crazychoir_fw.ros.sharing import share_poses, share_references
from crazychoir_fw.ros.tasks import TableDesk, TaskTable
from crazychoir_fw.ros.topic_experiment import READY
from crazychoir_fw.ros.trajectory import TrajectoryHandler

NOT_MADE = os.EX_CONFIG
"""Exit code of a process that cannot make the nodes of the mission."""

_LOOK_EVERY = 0.05  # [s], wall: period of the check for all partners
_LOOK_AT_CLOCK = 0.5  # [s], wall: period of the check for a publisher of the clock
_TRAFFIC = (
    "odom",
    "cmd_vel",
    "acceleration",
    "position",
    "fullstate",
    "answered",
    "clock",
    "closest_robots",
    "cmd_vel_des",
)


def make_nodes(
    mission: Any,
    part: Part,
    lockstep: bool,
    patience: float | None,
    context: Context | None = None,
) -> list[Node]:
    """Return the nodes of a part.

    Args:
        mission: The mission.
        part: Which of its layers.
        lockstep: Whether guidance answers each tick.
        patience: How long a guidance waits for neighbors while simulated time stands still (s, wall); None:
            `communication.silence_s` of the mission.
        context: Context of rclpy.

    Raises:
        CrazychoirError: If a layer of the mission cannot be made.
    """
    nodes: list[Node] = []
    if TABLE in part.layers:
        table = make_table(mission)
        assert table is not None
        nodes.append(TaskTable(table, parameters={"use_sim_time": True}, context=context))
    for i in part.agents:
        common: dict[str, Any] = {"agent_id": i, "parameters": {"use_sim_time": True}, "context": context}
        common["pose_handler"] = None  # of one subscription for all layers
        own: list[Any] = []
        for layer in layers_of_drone(mission, i):
            if layer not in part.layers:
                continue
            if layer == "guidance":
                own.append(_guidance(mission, i, lockstep, patience, common))
            elif layer == "planning":
                own.append(TrajectoryHandler(handler=agents.make_trajectory_handler(mission, i), **common))
            elif layer == "avoidance":
                own.append(make_avoidance_node(mission, **common))
            else:
                own.append(make_control_node(mission, **common))
        share_references(own)
        share_poses(own)
        nodes += own
    if SENSING in part.layers:
        nodes.append(make_sensing_node(mission, parameters={"use_sim_time": True}, context=context))
    return nodes


def _guidance(mission: Any, i: int, lockstep: bool, patience: float | None, common: dict[str, Any]) -> GuidanceNode:
    graph, settings = agents.graph_of(mission), mission.layers.communication_of(mission.fleet[i].id)

    whereabouts = PoseCache(graph.size) if goes_by_distance(mission) else None
    schedule = agents.schedule_of(mission, positions=None if whereabouts is None else whereabouts.positions)

    def build(node: GuidanceNode) -> Any:
        if whereabouts is not None:
            whereabouts.watch(node, sorted({i, *graph.in_neighbors(i), *graph.out_neighbors(i)}))
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
            # it has no neighbors: a transport of its own, so that the node does not wait for partners
            communicator = TimeVaryingCommunicator(i, graph.size, [], [], transport=RosTransport(node))
        made = agents.make_guidance(mission, i, communicator, schedule)
        if has_table(mission) and hasattr(made, "connect"):
            made.connect(TableDesk(node))
        return made

    parameters = {
        "use_sim_time": True,
        "lockstep": lockstep,
        "patience": settings.silence_s if patience is None else patience,
        "answers_early": settings.is_disturbed,
        "reference_answers": reference_answers(mission, i),
    }
    return GuidanceNode(build, update_frequency=float(mission.layers.rate), **{**common, "parameters": parameters})


def run_part(
    mission: Any, part: Part, lockstep: bool = True, patience: float | None = None, leave_after: float | None = None
) -> int:
    """Run the nodes of a part until ROS is shut down.

    Args:
        mission: The mission.
        part: The layers of this process.
        lockstep: Whether guidance answers each tick.
        patience: See `make_nodes`.
        leave_after: Time without a publisher of ``/clock`` after which this process ends (s, wall); None: never.

    Returns:
        The exit code.
    """
    context = Context()
    rclpy.init(args=[], context=context, signal_handler_options=SignalHandlerOptions.NO)
    is_spinning, is_over = threading.Event(), threading.Event()

    def end(*_: Any) -> None:
        # an exception in the middle of a callback would be reported as its failure, as would a context shut down
        is_over.set()
        if not is_spinning.is_set():
            context.try_shutdown()

    for sign in (signal.SIGINT, signal.SIGTERM):
        signal.signal(sign, end)
    executor, nodes = None, []
    try:
        executor = make_executor(context)
        try:
            nodes += make_nodes(mission, part, lockstep, patience, context)
        except CrazychoirError as error:
            if not context.ok():
                raise
            print(error, file=sys.stderr)
            return NOT_MADE
        for node in nodes:
            executor.add_node(node)
        is_spinning.set()
        spin(executor, nodes, part.name, context, leave_after, is_over.is_set)
    except ExternalShutdownException:
        pass
    except Exception:
        if context.ok():  # otherwise it was ended while its nodes were made
            raise
    finally:
        take_leave(executor, nodes, context)
    return 0


def take_leave(executor: Any | None, nodes: Iterable[Node], context: Context) -> None:
    """Destroy nodes, then shut their context down.

    A process that `multiprocessing` made ends without the interpreter's own destruction of objects: a middleware with
    shared memory would leak half a megabyte of it.
    """
    for node in nodes:
        with suppress(Exception):  # the context may be shut down already
            executor.remove_node(node)
            node.destroy_node()
    if executor is not None:
        executor.shutdown()
    rclpy.try_shutdown(context=context)


def make_executor(context: Context) -> Any:
    """Return the fastest executor that there is: events instead of wait sets cost a fifth per message."""
    try:
        from rclpy.experimental import EventsExecutor
    except ImportError:  # before Jazzy's patch 4, and in Humble
        from rclpy.executors import SingleThreadedExecutor

        return SingleThreadedExecutor(context=context)
    return EventsExecutor(context=context)


def spin(
    executor: Any,
    nodes: Sequence[Node],
    name: str,
    context: Context,
    leave_after: float | None = None,
    is_over: Callable[[], bool] = lambda: False,
) -> None:
    """Process messages, announce when all partners are found, and return when the clock has lost its publisher."""
    if not nodes:
        return
    announcer = nodes[0].create_publisher(String, READY, LATEST)
    is_ready = False
    looked = clock_looked = clock_seen = 0.0
    while context.ok() and not is_over():
        # works on many messages in one call: a call for each was a tenth of the time of a process
        executor.spin_until_future_complete(Future(), timeout_sec=0.1 if is_ready else _LOOK_EVERY)
        now = time.monotonic()
        if leave_after is not None and now - clock_looked > _LOOK_AT_CLOCK:
            clock_looked = now
            if nodes[0].count_publishers(CLOCK.name):
                clock_seen = now
            elif clock_seen and now - clock_seen > leave_after:
                nodes[0].get_logger().warning(f"nobody has published {CLOCK.name} for {leave_after:g} s: ends")
                return
        if not is_ready and now - looked > _LOOK_EVERY:
            looked = now
            if all(is_connected(node) for node in nodes):
                is_ready = True
                announcer.publish(String(data=name))


def is_connected(node: Node) -> bool:
    """Whether the topics that a node needs at every step have a publisher and a subscriber."""
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
