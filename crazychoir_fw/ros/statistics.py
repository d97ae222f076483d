"""Statistics of the communicators of a flight, sent to the host that writes summary.json.

Each guidance with neighbors publishes them once a second, so that the host has figures of a process that is killed, and
on request of the host at the end of a flight.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import Any

from rclpy.qos import QoSProfile
from std_msgs.msg import Empty, String

from crazychoir_fw.guidance.communicator_interface import Statistics
from crazychoir_fw.ros.node import LayerNode

STATISTICS = "/communication_statistics"
"""Topic (`std_msgs/String`, JSON) of the statistics that each guidance publishes."""

ASKED = "/tell_statistics"
"""Topic (`std_msgs/Empty`) on which the host requests statistics."""

EVERYBODY = QoSProfile(depth=1000)
"""Deep enough for answers of all agents at once: none may drop out of the queue."""

_NAMES = tuple(field.name for field in fields(Statistics))
TELL_EVERY = 1.0
"""Publishing period (s)."""
_LONGEST_WAIT_S = 3.0  # [s], wall


def told_of(agent: int, communicator: Any) -> dict[str, Any]:
    """Return the statistics of the communicator of an agent, as published."""
    return {"agent": agent, **vars(communicator.statistics)}


class StatisticsTeller:
    """Publishes the statistics of the communicator of one guidance."""

    def __init__(self, node: LayerNode, communicator: Any) -> None:
        """Make the publisher of a node, and the subscription to requests."""
        self._node, self._communicator = node, communicator
        self._publisher = node.create_publisher(String, STATISTICS, EVERYBODY)
        node.create_subscription(Empty, ASKED, lambda _: self.tell(), 10)
        self._begun = 0.0
        self._rounds, self._sum, self._longest = 0, 0.0, 0.0
        self._due = TELL_EVERY

    def round_begins(self) -> None:
        """Start the stopwatch of a round: its message goes out, and those of the neighbors are pending."""
        self._begun = time.perf_counter()

    def round_ends(self, now: float) -> None:
        """Stop the stopwatch: all messages came, or the deadline passed; `now` is the time of the node (s)."""
        took = time.perf_counter() - self._begun
        self._rounds += 1
        self._sum += took
        self._longest = max(self._longest, took)
        if now >= self._due:
            self._due = now + TELL_EVERY
            self.tell()

    def tell(self) -> None:
        """Publish the statistics now."""
        told = told_of(self._node.agent_id, self._communicator)
        if self._rounds:
            told["round_ms"] = {"mean": 1e3 * self._sum / self._rounds, "max": 1e3 * self._longest}
        self._publisher.publish(String(data=json.dumps(told)))


class RemoteCommunicator:
    """A communicator in another process: its latest statistics, for `statistics_of`."""

    def __init__(self, in_neighbors: Sequence[int], out_neighbors: Sequence[int]) -> None:
        """Begin with statistics of zero."""
        self.in_neighbors, self.out_neighbors = tuple(in_neighbors), tuple(out_neighbors)
        self.statistics = Statistics()
        self.round_ms: dict[str, float] | None = None
        """How long its rounds took (ms, wall): from sending its message to receiving all others; mean and max."""

    def take(self, told: dict[str, Any]) -> None:
        """Store published statistics; raises KeyError, TypeError or ValueError for anything else."""
        self.statistics = Statistics(**{name: int(told[name]) for name in _NAMES})
        took = told.get("round_ms")
        self.round_ms = None if took is None else {name: round(float(took[name]), 3) for name in ("mean", "max")}


class StatisticsCollector:
    """Collects the statistics of all agents, at the host."""

    def __init__(self, node: LayerNode, remote: dict[int, RemoteCommunicator]) -> None:
        """Subscribe a node to the statistics of agents, by number."""
        self._node, self._remote = node, remote
        self._missing: set[int] = set()
        self._ask = node.create_publisher(Empty, ASKED, 10)
        node.create_subscription(String, STATISTICS, self._take, EVERYBODY)

    def _take(self, message: String) -> None:
        try:
            told = json.loads(message.data)
            agent = int(told["agent"])
            self._remote[agent].take(told)
            self._missing.discard(agent)
        except (ValueError, KeyError, TypeError) as error:
            self._node.get_logger().warning(f"{STATISTICS}: {error!r}", throttle_duration_sec=1.0)

    def ask(self, agents: Sequence[int], work: Callable[[], None]) -> None:
        """Request the latest statistics, and wait for those of these agents, up to a timeout of a few seconds.

        Args:
            agents: Numbers of the agents that can still answer.
            work: Spins the node once.
        """
        self._missing = set(agents) & set(self._remote)
        if not self._missing:
            return
        self._ask.publish(Empty())
        deadline = time.monotonic() + _LONGEST_WAIT_S
        while self._missing and time.monotonic() < deadline:
            work()
