"""What a service is, the side of the drone of one or more CRTP ports, and its queue of packets for the drone."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Iterable
from typing import Protocol

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.crtp.service_context import ServiceContext

Reply = tuple[int, bytes]
"""Channel and payload; it goes back on the port of the request."""


class Service(Protocol):
    """One or more ports of one drone. Built with its `ServiceContext`; see there which thread may do what.

    Whatever it leaves with the world or the drone, an appointment or a listener, `ServiceContext.closing` takes off.
    """

    ports: tuple[int, ...]

    def receive(self, port: int, channel: int, payload: bytes) -> Iterable[Reply]:
        """Take one packet of at most 30 bytes and return the replies. Called by the radio thread.

        Any payload of any length may come. Whatever is wrong with it ends in the reply that the firmware would give, or
        in none; it never raises.
        """

    def end_session(self) -> None:
        """Forget what belongs to a client that has gone: its log blocks, for instance. Called by the radio thread."""


class CommandQueue:
    """Keeps the order of packets, and does not let them pile up while the simulation is paused."""

    def __init__(self, context: ServiceContext, limit: int = 100, *, newest_wins: bool = False) -> None:
        """Wait for packets.

        Args:
            context: The drone.
            limit: So many packets wait at most.
            newest_wins: Whether a packet beyond takes the place of the newest one that waits; otherwise it is lost.
        """
        self._context = context
        self._limit = limit
        self._newest_wins = newest_wins
        self._waiting: deque[tuple[int, int, bytes]] = deque()
        self._lock = threading.Lock()
        self.refused = 0
        """Packets that the drone did not understand, or did not accept."""
        self.lost = 0
        """Packets that came while too many waited."""

    def take(self, port: int, channel: int, payload: bytes) -> None:
        """Have the drone receive a packet; what it answers is sent."""
        with self._lock:
            if len(self._waiting) >= self._limit:
                self.lost += 1
                if self._newest_wins:
                    self._waiting[-1] = (port, channel, payload)
                return
            self._waiting.append((port, channel, payload))
        self._context.later(self._carry_out, is_bounded=True)

    def _carry_out(self) -> None:
        with self._lock:
            if not self._waiting:
                return
            port, channel, payload = self._waiting.popleft()
        try:
            answer = self._context.drone.receive_packet(port, channel, payload)
        except CrazychoirError:
            self.refused += 1
            return
        if answer is not None:
            self._context.send(port, channel, answer)
