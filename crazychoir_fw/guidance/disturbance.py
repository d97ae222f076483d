"""Messages that get lost, late or doubled on purpose."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from crazychoir_fw.common.checkpoint import Stateful
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.transport import Receiver, Transport

_BLOCK = 256  # random numbers that are drawn at once


class DisturbedTransport(Transport):
    """Another transport, of whose messages some get lost, come late, or come twice, for subscribers of this one.

    Each subscription has dice of its own, so that the fate of a message does not depend on other senders. `deliver`
    hands on the messages that are late; they may overtake each other.
    """

    is_lossless = False

    def __init__(
        self,
        inner: Transport,
        *,
        clock: Callable[[], float],
        loss: float = 0.0,
        delay: float = 0.0,
        jitter: float = 0.0,
        duplication: float = 0.0,
        seed: int | tuple[int, ...] = 0,
    ) -> None:
        """Choose what goes wrong.

        Args:
            inner: Carries the messages.
            clock: Returns the time (s).
            loss: Share of messages that get lost, [0, 1].
            delay: Least time that a message takes (s).
            jitter: Most time that it takes beyond that, evenly distributed (s).
            duplication: Share of messages that come twice, [0, 1].
            seed: Which ones.

        Raises:
            RangeError: If a number is outside its range.
        """
        for name, value in (("loss", loss), ("duplication", duplication)):
            if not 0.0 <= value <= 1.0:
                raise RangeError(f"{name} is {value}, allowed: [0, 1]")
        for name, value in (("delay", delay), ("jitter", jitter)):
            if not (math.isfinite(value) and value >= 0.0):
                raise RangeError(f"{name} is {value}, allowed: 0 s or more")
        self.carries_objects = inner.carries_objects
        self._inner, self._clock = inner, clock
        self._loss, self._delay, self._jitter, self._duplication = loss, delay, jitter, duplication
        self._seed = (seed,) if isinstance(seed, int) else seed
        self._subscriptions: dict[tuple[str, Receiver], Receiver] = {}
        self._dice: list[_Dice] = []
        self._late: list[tuple[float, int, Receiver, int, Any]] = []
        self._count = 0  # of late messages: equal times keep their order
        self.lost = 0
        """Messages that got lost."""
        self.doubled = 0
        """Messages that came twice."""

    def publish(self, topic: str, label: int, data: Any) -> None:
        """Hand the data to the other transport."""
        self._inner.publish(topic, label, data)

    def advertise(self, topic: str, *, reliable: bool = True) -> None:
        """Say so to the other transport."""
        self._inner.advertise(topic, reliable=reliable)

    def subscribe(self, topic: str, callback: Receiver) -> None:
        """Call ``callback(label, data)`` for every message that is not lost."""
        dice = _Dice(np.random.default_rng([*self._seed, *topic.encode()]))
        self._dice.append(dice)

        def receive(label: int, data: Any) -> None:
            if dice.throw() < self._loss:
                self.lost += 1
                return
            self._hand_on(dice, callback, label, data)
            if dice.throw() < self._duplication:
                self.doubled += 1
                self._hand_on(dice, callback, label, data)

        self._subscriptions[topic, callback] = receive
        self._inner.subscribe(topic, receive)

    def _hand_on(self, dice: _Dice, callback: Receiver, label: int, data: Any) -> None:
        takes = self._delay + self._jitter * dice.throw()
        if takes > 0.0:
            self._count += 1
            heapq.heappush(self._late, (self._clock() + takes, self._count, callback, label, data))
            self.has_waiting = True
        else:
            callback(label, data)

    def deliver(self) -> None:
        """Hand on what is due."""
        now = self._clock() + 1e-9  # times of rounds are sums of periods
        while self._late and self._late[0][0] <= now:
            _, _, callback, label, data = heapq.heappop(self._late)
            callback(label, data)
        self.has_waiting = bool(self._late)

    def unsubscribe(self, topic: str, callback: Receiver) -> None:
        """Let `callback` be called no more."""
        receive = self._subscriptions.pop((topic, callback), None)
        if receive is not None:
            self._inner.unsubscribe(topic, receive)
        self._late = [one for one in self._late if one[2] is not callback]
        heapq.heapify(self._late)


class _Dice(Stateful):
    """Numbers in [0, 1), drawn in blocks: one at a time costs ten times as much."""

    def __init__(self, generator: np.random.Generator) -> None:
        self._generator = generator
        self._drawn: list[float] = []

    def throw(self) -> float:
        if not self._drawn:
            self._drawn = self._generator.random(_BLOCK).tolist()[::-1]
        return self._drawn.pop()
