"""`PeerRegistry`: the processes of layers that the host of the drones serves with bundles, and who listens besides."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from rclpy.publisher import Publisher
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from std_msgs.msg import String

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.ros import bundles
from crazychoir_fw.ros.bundles import FRESH_S, LOOK_EVERY, HostCard, MemberCard
from crazychoir_fw.ros.names import LATEST

if TYPE_CHECKING:
    from crazychoir_fw.ros.node import LayerNode


@dataclass
class _Member:
    """A process that takes bundles."""

    served: Mapping[str, int]
    """How many of its subscriptions on which topics."""
    asked: float | None = None
    """When the first bundle went out that it has not answered (s, wall)."""
    is_there: bool = True


class PeerRegistry:
    """The other end of all `Hub`s.

    A member that has not answered for a second counts as gone until it answers: its subscriptions are then served one
    by one, as anybody's, so that nobody is ever left out.
    """

    def __init__(self, node: LayerNode, odometry: Sequence[str]) -> None:
        """Begin without members.

        Args:
            node: Whose publishers and subscriptions are used.
            odometry: Topics (absolute names) of the odometry, in the order of the rows.
        """
        self._node = node
        self._odometry = list(odometry)
        self._members: dict[str, _Member] = {}
        self._served: Counter[str] = Counter()
        self._callbacks: dict[str, list[Callable[[bytes], None]]] = {}
        self._outside: dict[str, bool] = {}
        self._look_wall = -np.inf
        self._bundles = node.announce(bundles.ODOMETRY)
        self._host = node.create_publisher(String, bundles.HOST.name, LATEST)
        node.listen(bundles.ANSWERS, self._take_answers, raw=True)
        everybody = QoSProfile(depth=1000, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
        node.listen(bundles.MEMBERS, lambda message: self._take_member(message.data), profile=everybody)

    def hear(self, topic: str, callback: Callable[[bytes], None]) -> None:
        """Take messages of a topic also from bundles; there is a subscription with the same callback."""
        self._callbacks.setdefault(topic, []).append(callback)

    def invite(self) -> None:
        """Say who we are, once all that is heard is known."""
        card = HostCard(self._odometry, {topic: len(heard) for topic, heard in self._callbacks.items()})
        self._host.publish(String(data=card.text()))

    def send(self, nanoseconds: int, rows: NDArray[np.float64]) -> None:
        """Bundle the odometry of all drones, shape (N, 13), if somebody takes it."""
        now = time.monotonic()
        for member in self._members.values():
            if member.asked is None:
                member.asked = now
            elif member.is_there and now - member.asked > FRESH_S:
                member.is_there = False
                self._count()
        if self._members:
            self._bundles.publish(bundles.pack_odometry(nanoseconds, rows))

    def look(self) -> None:
        """Look, now and then, who else listens."""
        now = time.monotonic()
        if now - self._look_wall >= LOOK_EVERY:
            self._look_wall = now
            self._outside.clear()

    def is_heard_outside(self, publisher: Publisher, topic: str) -> bool:
        """Return whether somebody listens to a topic whom no bundle reaches."""
        served = self._served[topic]
        if not served:
            return True
        if topic not in self._outside:
            self._outside[topic] = publisher.get_subscription_count() > served
        return self._outside[topic]

    def _take_member(self, text: str) -> None:
        card = MemberCard.read(text)
        self._members[card.member] = _Member(card.served)
        self._count()

    def _take_answers(self, data: bytes) -> None:
        _, name, said = bundles.unpack_answers(data)
        member = self._members.get(name)
        if member is not None:
            member.asked = None
            if not member.is_there:
                member.is_there = True
                self._count()
        for topic, message in said:
            callbacks = self._callbacks.get(topic)
            if callbacks is None:
                raise RangeError(f"{name} says something on {topic}, which is not heard from bundles")
            for callback in callbacks:
                callback(message)

    def _count(self) -> None:
        self._served = Counter()
        for member in self._members.values():
            if member.is_there:
                self._served.update(member.served)
        self._outside.clear()
