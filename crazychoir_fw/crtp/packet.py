"""CRTP packets as they travel: one header byte and up to 30 bytes of payload (docs/reference/crtp-cflib.md#3.1)."""

from __future__ import annotations

import enum
from typing import NamedTuple

MAX_PAYLOAD = 30


class Port(enum.IntEnum):
    """The port of a packet: the service that receives it."""

    CONSOLE = 0
    PARAM = 2
    COMMANDER = 3
    MEMORY = 4
    LOG = 5
    LOCALIZATION = 6
    COMMANDER_GENERIC = 7
    COMMANDER_HIGH_LEVEL = 8
    SUPERVISOR = 9
    PLATFORM = 13
    LINK = 15


HEADERS = tuple(tuple(bytes((port << 4 | 0x0C | channel,)) for channel in range(4)) for port in range(16))
"""First byte of a packet, by port and channel, with the two reserved bits set as cflib does."""


class Packet(NamedTuple):
    """One packet."""

    port: int
    """0 to 15."""
    channel: int
    """0 to 3."""
    payload: bytes = b""

    def to_bytes(self) -> bytes:
        """Return the datagram."""
        return HEADERS[self.port][self.channel] + self.payload


def parse(datagram: bytes) -> Packet | None:
    """Return the packet in a datagram, or None if it is empty or too long to be one."""
    if not 1 <= len(datagram) <= 1 + MAX_PAYLOAD:
        return None
    return Packet(datagram[0] >> 4, datagram[0] & 0x03, datagram[1:])


NULL = b"\xff"
"""A null packet: what scanners send, and are answered with."""
