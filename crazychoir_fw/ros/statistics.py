"""What the communicators of a flight have seen, told to the host that writes summary.json.

Each guidance that has neighbors tells it once a second, so that something is known of a process that is killed, and
when the host asks at the end of a flight.
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
"""Topic (`std_msgs/String`, JSON) on which each guidance tells what its communicator has seen."""

ASKED = "/tell_statistics"
"""Topic (`std_msgs/Empty`) on which the host asks for it."""

EVERYBODY = QoSProfile(depth=1000)
"""Many answer at once, and none of them may push another one out."""

_NAMES = tuple(field.name for field in fields(Statistics))
TELL_EVERY = 1.0
"""Time between two tellings (s)."""
_LONGEST_WAIT_S = 3.0  # [s], wall


def told_of(agent: int, communicator: Any) -> dict[str, Any]:
    """Return what is told of the communicator of an agent."""
    return {"agent": agent, **vars(communicator.statistics)}


class StatisticsTeller:
    """Tells what the communicator of one guidance has seen."""

    def __init__(self, node: LayerNode, communicator: Any) -> None:
        """Tell it of a node."""
        self._node, self._communicator = node, communicator
        self._publisher = node.create_publisher(String, STATISTICS, EVERYBODY)
        node.create_subscription(Empty, ASKED, lambda _: self.tell(), 10)
        self._begun = 0.0
        self._rounds, self._sum, self._longest = 0, 0.0, 0.0
        self._due = TELL_EVERY

    def round_begins(self) -> None:
        """A message goes out, and those of the neighbors are waited for."""
        self._begun = time.perf_counter()

    def round_ends(self, now: float) -> None:
        """They are there, or nobody waits any more; `now` is the time of the node (s)."""
        took = time.perf_counter() - self._begun
        self._rounds += 1
        self._sum += took
        self._longest = max(self._longest, took)
        if now >= self._due:
            self._due = now + TELL_EVERY
            self.tell()

    def tell(self) -> None:
        """Tell it now."""
        told = told_of(self._node.agent_id, self._communicator)
        if self._rounds:
            told["round_ms"] = {"mean": 1e3 * self._sum / self._rounds, "max": 1e3 * self._longest}
        self._publisher.publish(String(data=json.dumps(told)))


class RemoteCommunicator:
    """A communicator somewhere else: what it told of itself, for `statistics_of`."""

    def __init__(self, in_neighbors: Sequence[int], out_neighbors: Sequence[int]) -> None:
        """Nothing is known yet."""
        self.in_neighbors, self.out_neighbors = tuple(in_neighbors), tuple(out_neighbors)
        self.statistics = Statistics()
        self.round_ms: dict[str, float] | None = None
        """How long its rounds took (ms, wall): from its message until all others were there; mean and longest."""

    def take(self, told: dict[str, Any]) -> None:
        """Take what it told; raises KeyError, TypeError or ValueError for anything else."""
        self.statistics = Statistics(**{name: int(told[name]) for name in _NAMES})
        took = told.get("round_ms")
        self.round_ms = None if took is None else {name: round(float(took[name]), 3) for name in ("mean", "max")}


class StatisticsCollector:
    """Hears the statistics of all, at the host."""

    def __init__(self, node: LayerNode, remote: dict[int, RemoteCommunicator]) -> None:
        """Hear those of agents, by number, at a node."""
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
        """Ask for the latest, and wait for the answers of these agents, for a few seconds at most.

        Args:
            agents: Who is there to answer.
            work: Works on messages for a moment.
        """
        self._missing = set(agents) & set(self._remote)
        if not self._missing:
            return
        self._ask.publish(Empty())
        deadline = time.monotonic() + _LONGEST_WAIT_S
        while self._missing and time.monotonic() < deadline:
            work()
