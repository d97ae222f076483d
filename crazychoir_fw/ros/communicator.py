"""`RosTransport`: messages between agents as ROS topics, for the communicators of `crazychoir_fw.guidance`.

Topics are those of docs/reference/crazychoir.md#17.2: ``/agent_{i}/communicator``, or ``/agent_{i}/communicator_{j}``
with one topic per receiver. A message is a ``std_msgs/UInt8MultiArray`` whose only dimension is labeled with the number
of the round.

Reliable topics are volatile, unlike the original's: whoever comes late would first be told all rounds that are over,
and takes over the label of the others anyway.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSDurabilityPolicy, QoSHistoryPolicy, QoSProfile, QoSReliabilityPolicy
from rclpy.subscription import Subscription
from std_msgs.msg import UInt8MultiArray

from crazychoir_fw.common.errors import MessageError, RangeError
from crazychoir_fw.guidance.serialization import dumps, loads
from crazychoir_fw.guidance.transport import Receiver, Transport
from crazychoir_fw.ros.publisher import SharedPublisher
from crazychoir_fw.ros.wire import label_and_data, labeled_bytes

RELIABLE = QoSProfile(
    depth=100,  # rounds that a neighbor may be ahead; in lock step it is one
    history=QoSHistoryPolicy.KEEP_LAST,
    reliability=QoSReliabilityPolicy.RELIABLE,
    durability=QoSDurabilityPolicy.VOLATILE,
)
"""Of lock-step communicators."""

BEST_EFFORT = QoSProfile(
    depth=10,
    history=QoSHistoryPolicy.KEEP_LAST,
    reliability=QoSReliabilityPolicy.BEST_EFFORT,
    durability=QoSDurabilityPolicy.VOLATILE,
)
"""Of best-effort communicators."""


class RosTransport(Transport):
    """Topics of a node. Callbacks come in the thread of the node's executor.

    Agents of one process whose nodes share a hub hand each other objects; bytes are made for others only.
    """

    def __init__(self, node: Node, *, reliable: bool = True) -> None:
        """Use a node.

        Args:
            node: Whose publishers and subscriptions carry the messages.
            reliable: Whether what is subscribed to is asked for reliably; best effort hears both kinds of publishers.
        """
        self._node = node
        self._hub = getattr(node, "hub", None)
        self.carries_objects = self._hub is not None
        self._qos = RELIABLE if reliable else BEST_EFFORT
        self._outlets: dict[str, SharedPublisher] = {}
        self._subscriptions: dict[tuple[str, Receiver], Subscription] = {}
        self._direct: dict[tuple[str, Receiver], Callable[[Any], None]] = {}
        self.when_received: list[Callable[[], None]] = []
        """Called after each message, for users who wait for no one but are told."""

    def advertise(self, topic: str, *, reliable: bool = True) -> None:
        """Make the publisher of a topic."""
        qos = RELIABLE if reliable else BEST_EFFORT
        self._outlets[topic] = SharedPublisher(
            self._node.create_publisher(UInt8MultiArray, _absolute(topic), qos), self._hub
        )

    def publish(self, topic: str, label: int, data: Any) -> None:
        """Send bytes of a round, or an object, to all who subscribed to the topic."""
        if topic not in self._outlets:
            self.advertise(topic)
        self._outlets[topic].say((label, data), self._encoded)

    def _encoded(self, message: tuple[int, Any]) -> bytes:
        label, data = message
        return labeled_bytes(label, dumps(data) if self.carries_objects else data)

    def subscribe(self, topic: str, callback: Receiver) -> None:
        """Have ``callback(label, data)`` called for every message; one without label is told to the log."""
        hub = self._hub
        echoes = () if hub is None else hub.echoes(_absolute(topic))

        def take(message: tuple[int, Any]) -> None:
            callback(*message)
            # while a bundle is handed out, all rounds are looked at afterwards
            if not hub.is_working:
                for told in self.when_received:
                    told()

        def receive(message: bytes) -> None:
            if message in echoes:
                return
            try:
                label, data = label_and_data(message)
                if self.carries_objects:
                    data = loads(data)
            except (RangeError, MessageError) as error:
                self._node.get_logger().warning(f"{topic}: {error}", throttle_duration_sec=1.0)
                return
            callback(label, data)
            for told in self.when_received:
                told()

        if hub is not None:
            self._direct[topic, callback] = take
            hub.listeners(_absolute(topic)).append(take)
        self._subscriptions[topic, callback] = self._node.create_subscription(
            UInt8MultiArray, _absolute(topic), receive, self._qos, raw=True
        )

    def unsubscribe(self, topic: str, callback: Receiver) -> None:
        """Let `callback` be called no more."""
        subscription = self._subscriptions.pop((topic, callback), None)
        if subscription is not None:
            self._node.destroy_subscription(subscription)
        if self._hub is not None and (topic, callback) in self._direct:
            self._hub.listeners(_absolute(topic)).remove(self._direct.pop((topic, callback)))

    @property
    def is_heard_outside(self) -> bool:
        """Whether somebody outside of this process listens."""
        return any(one.is_heard_outside for one in self._outlets.values())

    @property
    def is_connected(self) -> bool:
        """Whether somebody is at the other end of every topic."""
        return all(one.listeners for one in self._outlets.values()) and all(
            one.get_publisher_count() for one in self._subscriptions.values()
        )


def _absolute(topic: str) -> str:
    return topic if topic.startswith("/") else f"/{topic}"
