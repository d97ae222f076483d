"""What a service is: the side of the drone of one or more CRTP ports."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol

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
