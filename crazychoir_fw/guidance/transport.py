"""How messages travel between communicators."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

import numpy as np

from crazychoir_fw.common.checkpoint import Stateful
from crazychoir_fw.common.errors import RangeError

Receiver = Callable[[int, Any], None]
"""Takes the label of a message and its data."""


class Transport(Stateful, ABC):
    """Topics with labels. Messages of one publisher arrive in order; some may be lost."""

    carries_objects: bool = False
    """Data are the objects themselves, frozen, and not bytes."""
    is_lossless: bool = False
    """Whether each message arrives, once, before `publish` returns."""
    has_waiting: bool = False
    """Whether messages wait for `deliver`."""

    @abstractmethod
    def publish(self, topic: str, label: int, data: Any) -> None:
        """Send data (bytes, or an object where `carries_objects`) of a round to all subscribers of the topic."""

    @abstractmethod
    def subscribe(self, topic: str, callback: Receiver) -> None:
        """Have `callback(label, data)` called for every message, from any thread."""

    def advertise(self, topic: str, *, reliable: bool = True) -> None:
        """Say that the topic will be published to, and whether messages may get lost. Not every transport cares."""

    def deliver(self) -> None:
        """Hand on messages that are due. Most transports do so by themselves."""

    @abstractmethod
    def unsubscribe(self, topic: str, callback: Receiver) -> None:
        """Let `callback` be called no more."""


class InProcessTransport(Transport):
    """Between agents of one process: messages arrive before `publish` returns, in the thread that published.

    Same calls give the same losses, whatever the time is.
    """

    def __init__(self, *, serialize: bool = False, loss: float = 0.0, seed: int = 0) -> None:
        """Make the medium that the communicators share.

        Args:
            serialize: Carry bytes, as a network would.
            loss: Share of messages that get lost, each for each receiver, [0, 1].
            seed: Which ones.

        Raises:
            RangeError: If the loss is outside its range.
        """
        if not 0.0 <= loss <= 1.0:
            raise RangeError(f"loss is {loss}, allowed: [0, 1]")
        self.carries_objects = not serialize
        self.is_lossless = not loss
        self._loss = loss
        self._dice = np.random.default_rng(seed)
        self._receivers: dict[str, tuple[Receiver, ...]] = {}

    def publish(self, topic: str, label: int, data: Any) -> None:
        """Hand the data to all subscribers of the topic."""
        receivers = self._receivers.get(topic, ())
        if self._loss:
            receivers = tuple(receiver for receiver in receivers if self._dice.random() >= self._loss)
        for receiver in receivers:
            receiver(label, data)

    def subscribe(self, topic: str, callback: Receiver) -> None:
        """Have `callback(label, data)` called for every message."""
        # a new tuple each time, so that a thread that publishes meanwhile is not disturbed
        self._receivers[topic] = (*self._receivers.get(topic, ()), callback)

    def unsubscribe(self, topic: str, callback: Receiver) -> None:
        """Let `callback` be called no more."""
        self._receivers[topic] = tuple(one for one in self._receivers.get(topic, ()) if one != callback)
