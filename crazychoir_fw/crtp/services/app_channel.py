"""The app channel (port 13, channel 2): bytes between a program on the ground and one on the drone."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.crtp.packet import MAX_PAYLOAD, Port
from crazychoir_fw.crtp.service_context import ServiceContext

CHANNEL = 2
MAX_WAITING = 100
"""Messages of the client that wait for the simulation; more are lost."""


class AppChannel:
    """The drone's end of the channel, for Python that stands in for an app on board.

    Messages wait in `received` until `receive` fetches them. With a `callback` they do not wait: it is called with each
    of them by the simulation thread between two steps, so that it may do to the drone whatever it likes.
    """

    def __init__(self, context: ServiceContext) -> None:
        self._context = context
        self._lock = threading.Lock()
        self.received: deque[bytes] = deque()
        """What the client has sent and nobody has fetched, oldest first."""
        self.lost = 0
        """How many messages came while too many waited."""
        self.callback: Callable[[bytes], None] | None = None
        """Called with every message, instead of letting it wait."""
        self._is_called = False  # the simulation will look

    def send(self, data: bytes) -> None:
        """Send a message to the client, if there is one; cflib hands it to `appchannel.packet_received`.

        Raises:
            RangeError: If it is empty or longer than 30 bytes.
        """
        if not 1 <= len(data) <= MAX_PAYLOAD:
            raise RangeError(f"{self._context.drone.id}: app channel: {len(data)} bytes, allowed: 1 to {MAX_PAYLOAD}")
        self._context.send(Port.PLATFORM, CHANNEL, bytes(data))

    def receive(self) -> bytes | None:
        """Return the oldest message that waits, or None. Any thread may call this."""
        with self._lock:
            return self.received.popleft() if self.received else None

    def take(self, data: bytes) -> None:
        """Take a message of the client; the radio thread calls this."""
        with self._lock:
            if len(self.received) >= MAX_WAITING:
                self.lost += 1
                return
            self.received.append(data)
        if self.callback is not None:
            self._call_soon()

    def _call_soon(self) -> None:
        with self._lock:
            if self._is_called or not self.received:
                return
            self._is_called = True
        self._context.later(self._call_back, is_bounded=True)

    def _call_back(self) -> None:
        with self._lock:
            self._is_called = False
        try:
            while self.callback is not None and (data := self.receive()) is not None:
                self.callback(data)
        except BaseException:
            self._call_soon()  # the others do not wait for the next message
            raise
