"""What all memories have in common."""

from __future__ import annotations

import enum
from typing import Protocol


class MemoryType(enum.IntEnum):
    """Types as clients know them; those that a simulated drone can have."""

    EEPROM = 0x00
    ONE_WIRE = 0x01
    LED_RING = 0x10
    LOCO = 0x11
    TRAJECTORY = 0x12
    LOCO_2 = 0x13
    LIGHTHOUSE = 0x14
    TESTER = 0x15
    LED_TIMINGS = 0x17
    DECK = 0x19


NO_SERIAL = bytes(8)


class Memory(Protocol):
    """One memory of one drone. The radio thread calls it; see `crazychoir_fw.crtp.service_context`."""

    type: MemoryType
    size: int
    """Bytes, as the client is told. Nobody asks for bytes behind the end."""
    serial: bytes
    """8 bytes, which only 1-wire memories have; elsewhere zeros."""

    def read(self, address: int, length: int) -> bytes | None:
        """Return so many bytes, or None where there are none."""

    def write(self, address: int, data: bytes) -> bool:
        """Take bytes. Returns False when they are refused."""


class ReadOnlyMemory:
    """The half of a memory that refuses."""

    serial = NO_SERIAL

    def write(self, address: int, data: bytes) -> bool:
        """Refuse."""
        return False


def slice_of(content: bytes, start: int, address: int, length: int) -> bytes | None:
    """Return bytes at an address out of content that lies at `start`, or None when they are not all in there."""
    offset = address - start
    return content[offset : offset + length] if 0 <= offset <= len(content) - length else None
