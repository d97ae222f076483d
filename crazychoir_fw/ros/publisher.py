"""`SharedPublisher`: a publisher that hands its values to listeners of its own process, and uses ROS for all others."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.publisher import Publisher

from crazychoir_fw.ros.hub import Hub


class SharedPublisher:
    """Where values leave a node."""

    def __init__(self, publisher: Publisher, hub: Hub | None) -> None:
        """Wrap a publisher.

        Args:
            publisher: Reaches whoever is outside.
            hub: Of the process; None: everybody is outside.
        """
        self._publisher = publisher
        self._hub = hub
        self._topic = publisher.topic_name
        if hub is not None:
            self._inside = hub.listeners(self._topic)
            self._echoes = hub.echoes(self._topic)
            self._looked = -1
            self._outside, self._host = 0, 0

    def say(self, value: Any, encode: Callable[[Any], bytes]) -> None:
        """Say something.

        Args:
            value: Handed to listeners of this process as it is: nobody may change it.
            encode: Makes it the bytes of a message, for others.
        """
        hub = self._hub
        if hub is None:
            self._publisher.publish(encode(value))
            return
        if self._looked != hub.looks:
            self._look(hub)
        if self._outside > 0:
            data = encode(value)
            if self._inside:
                self._echoes.append(data)
            self._publisher.publish(data)
        elif self._host:
            hub.say(self._topic, encode(value))
        for take in self._inside:
            take(value)

    def _look(self, hub: Hub) -> None:
        self._looked = hub.looks
        self._host = hub.host_hears(self._topic)
        self._outside = self._publisher.get_subscription_count() - len(self._inside) - self._host

    @property
    def is_heard_outside(self) -> bool:
        """Whether somebody listens who is not of this process, nor served with bundles."""
        hub = self._hub
        if hub is None:
            return self._publisher.get_subscription_count() > 0
        if self._looked != hub.looks:
            self._look(hub)
        return self._outside > 0

    @property
    def listeners(self) -> int:
        """How many subscriptions there are, inside and outside."""
        return int(self._publisher.get_subscription_count())
