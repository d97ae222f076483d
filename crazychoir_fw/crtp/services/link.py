"""Port 15, the link service: echo, source and sink (docs/reference/crtp-cflib.md#5)."""

from __future__ import annotations

from collections.abc import Iterable

from crazychoir_fw.crtp.packet import MAX_PAYLOAD, Port
from crazychoir_fw.crtp.service_context import ServiceContext
from crazychoir_fw.crtp.services.service import Reply

ECHO, SOURCE, SINK, NULL_CHANNEL = range(4)

GREETING = b"Bitcraze Crazyflie".ljust(MAX_PAYLOAD, b"\0")
"""By this a client tells that the protocol version can be asked for."""


class LinkService:
    """Returns what it gets, says who it is, or swallows."""

    ports = (Port.LINK,)

    def __init__(self, context: ServiceContext) -> None:
        pass

    def receive(self, port: int, channel: int, payload: bytes) -> Iterable[Reply]:
        """Answer an echo with itself and a question for the source with the greeting."""
        if channel == ECHO:
            return ((ECHO, payload),)
        if channel == SOURCE:
            return ((SOURCE, GREETING),)
        return ()

    def end_session(self) -> None:
        """There is nothing to forget."""
