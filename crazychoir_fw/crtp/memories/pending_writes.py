"""Writes that wait for the simulation, and what a memory looks like when they have been made."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.crtp.service_context import ServiceContext


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
