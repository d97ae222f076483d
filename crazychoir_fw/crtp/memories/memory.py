"""What memories have in common: the protocol, bytes that the core keeps (`bindings/memories.h`), and pending writes."""

from __future__ import annotations

import enum
import threading
from collections import deque
from collections.abc import Callable
from typing import Protocol

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.crtp.service_context import ServiceContext


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
    """Bytes, as announced to the client. No read goes beyond the end."""
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


class PendingWrites:
    """A client gets its answer at once, and reads what it wrote, also while the simulation stands still."""

    def __init__(self, context: ServiceContext, write: Callable[[int, bytes], object]) -> None:
        """Begin without any.

        Args:
            context: ServiceContext of the drone.
            write: Called by the simulation thread with address and data of one write, in the order of their coming.
        """
        self._context = context
        self._write = write
        self._waiting: deque[tuple[int, bytes]] = deque()
        self._lock = threading.Lock()

    def add(self, address: int, data: bytes) -> bool:
        """Have data written later; only the radio thread calls this.

        Returns:
            False when too much waits already.
        """
        with self._lock:
            self._waiting.append((address, data))
        if self._context.later(self._carry_out_first):
            return True
        with self._lock:
            self._waiting.pop()
        return False

    def _carry_out_first(self) -> None:
        try:
            self._write(*self._waiting[0])
        except CrazychoirError:
            pass  # the drone refused what it would have taken when the client was answered
        finally:
            with self._lock:
                self._waiting.popleft()

    def read(self, read: Callable[[int, int], bytes | None], address: int, length: int) -> bytes | None:
        """Return what `read(address, length)` will return when all that waits has been written."""
        # the list first: what is carried out meanwhile is written over itself
        with self._lock:
            waiting = tuple(self._waiting)
        content = read(address, length)
        if content is None or not waiting:
            return content
        return overlaid(content, address, waiting)


def overlaid(content: bytes, address: int, writes: tuple[tuple[int, bytes], ...]) -> bytes:
    """Return the bytes at an address with writes made over them, one after the other."""
    result, end = bytearray(content), address + len(content)
    for start, data in writes:
        first, last = max(start, address), min(start + len(data), end)
        if first < last:
            result[first - address : last - address] = data[first - start : last - start]
    return bytes(result)


class CoreMemory:
    """Read out of the drone, written into it by its uplink."""

    type: MemoryType
    serial = NO_SERIAL

    def __init__(self, context: ServiceContext) -> None:
        self.size: int = lib.cf_memory_bytes(self.type)
        self._drone = context.drone
        self._pending = PendingWrites(context, self._deliver)

    def read(self, address: int, length: int) -> bytes | None:
        """Return bytes as they are when everything that waits has been written."""
        return self._pending.read(self._present, address, length)

    def write(self, address: int, data: bytes) -> bool:
        """Have bytes written between two steps."""
        return self._pending.add(address, data)

    def _present(self, address: int, length: int) -> bytes | None:
        data = ffi.new("uint8_t[]", length)
        status = lib.cf_read_memory(self._drone.struct, self.type, address, length, data)
        return bytes(data) if status == lib.CF_OK else None

    def _deliver(self, address: int, data: bytes) -> None:
        self._drone.uplink.request("cf_write_memory", int(self.type), address, len(data), data)
