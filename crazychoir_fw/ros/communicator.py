"""`RosTransport`: messages between agents as ROS topics, for the communicators of `crazychoir_fw.guidance`.

Topics are those of docs/reference/crazychoir.md#17.2: ``/agent_{i}/communicator``, or ``/agent_{i}/communicator_{j}``
with one topic per receiver. A message is a ``std_msgs/UInt8MultiArray`` whose only dimension is labeled with the number
of the round.

Reliable topics are volatile, unlike the original's. With transient-local durability an agent that joins late would
first receive all past rounds; it adopts the round label of its neighbors anyway.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSDurabilityPolicy, QoSHistoryPolicy, QoSProfile, QoSReliabilityPolicy
from rclpy.subscription import Subscription
from std_msgs.msg import UInt8MultiArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.transport import Receiver, Transport
from crazychoir_fw.ros.conversions import from_bytes, labeled_bytes, message_to_bytes

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
    """Topics of a node. Callbacks come in the thread of the node's executor."""

    def __init__(self, node: Node, *, reliable: bool = True) -> None:
        """Use a node.

        Args:
            node: Node that owns the publishers and subscriptions.
            reliable: Whether subscriptions request reliable delivery; best effort matches both kinds of publishers.
        """
        self._node = node
        self._qos = RELIABLE if reliable else BEST_EFFORT
        self._publishers: dict[str, Publisher] = {}
        self._subscriptions: dict[tuple[str, Receiver], Subscription] = {}
        self.when_received: list[Callable[[], None]] = []
        """Callbacks after each received message, for nodes that do not block on a round."""

    def advertise(self, topic: str, *, reliable: bool = True) -> None:
        """Make the publisher of a topic."""
        qos = RELIABLE if reliable else BEST_EFFORT
        self._publishers[topic] = self._node.create_publisher(UInt8MultiArray, _absolute(topic), qos)

    def publish(self, topic: str, label: int, data: Any) -> None:
        """Send bytes of a round to all subscribers of the topic."""
        if topic not in self._publishers:
            self.advertise(topic)
        self._publishers[topic].publish(labeled_bytes(label, data))

    def subscribe(self, topic: str, callback: Receiver) -> None:
        """Have ``callback(label, data)`` called for every message; a message without label is logged and dropped."""

        def receive(raw: bytes) -> None:
            try:
                label, data = message_to_bytes(from_bytes(raw, UInt8MultiArray))
            except RangeError as error:
                self._node.get_logger().warning(f"{topic}: {error}", throttle_duration_sec=1.0)
                return
            callback(label, data)
            for told in self.when_received:
                told()

        self._subscriptions[topic, callback] = self._node.create_subscription(
            UInt8MultiArray, _absolute(topic), receive, self._qos, raw=True
        )

    def unsubscribe(self, topic: str, callback: Receiver) -> None:
        """Remove the subscription of `callback`."""
        subscription = self._subscriptions.pop((topic, callback), None)
        if subscription is not None:
            self._node.destroy_subscription(subscription)

    @property
    def is_connected(self) -> bool:
        """Whether every publisher has a subscriber, and every subscription a publisher."""
        return all(one.get_subscription_count() for one in self._publishers.values()) and all(
            one.get_publisher_count() for one in self._subscriptions.values()
        )


def _absolute(topic: str) -> str:
    return topic if topic.startswith("/") else f"/{topic}"
