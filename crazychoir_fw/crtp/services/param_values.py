"""Values of a drone's parameters as bytes: what they are, what is about to be written, what the client believes.

Values are read wherever the client asks, also while the drone ticks. Writes wait for the simulation; until they are
carried out, a reading gives what was written last. So a client never sees an old value behind a write of its own.
"""

from __future__ import annotations

import math
import struct
import threading
from functools import partial

import numpy as np

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.crtp.service_context import ServiceContext
from crazychoir_fw.crtp.toc import TableOfContents

MAX_WAITING = 300
"""Writes of one drone that wait for the simulation: a client may set every parameter at once."""

MAX_NEWS = 20
"""Max changes sent at once; the others follow. A drone that reboots changes hundreds."""

_FORMATS = {"u1": "<B", "u2": "<H", "u4": "<L", "i1": "<b", "i2": "<h", "i4": "<l", "f4": "<f"}


class ParameterValues:
    """All parameters of one drone, by number."""

    def __init__(self, context: ServiceContext, toc: TableOfContents) -> None:
        self._context = context
        self._toc = toc
        self._bytes = memoryview(context.drone.memory)
        self._memory = context.drone.memory
        self._places = [(row.offset, row.offset + row.dtype.itemsize) for row in toc.variables]
        self._packers = [struct.Struct(_FORMATS[row.dtype.str[1:]]) for row in toc.variables]
        self._lock = threading.Lock()
        self._waiting = 0
        self._pending: dict[int, tuple[bytes, int]] = {}  # newest bytes, and how many writes wait
        # what the client believes, all parameters behind each other
        sizes = np.array([packer.size for packer in self._packers])
        ends = np.cumsum(sizes)
        self._parts = [slice(end - size, end) for end, size in zip(ends.tolist(), sizes.tolist(), strict=True)]
        self._owners = np.repeat(np.arange(len(sizes)), sizes)
        self._addresses = np.concatenate([np.arange(*place) for place in self._places])
        self._told = np.zeros(len(self._owners), np.uint8)
        self._is_told = np.zeros(len(self._owners), bool)
        # single values change faster past numpy
        self._told_bytes = memoryview(self._told)
        self._is_told_bytes = memoryview(self._is_told.view(np.uint8))
        self._ones = [b"\1" * size for size in sizes.tolist()]
        self._has_told = False

    def size(self, number: int) -> int:
        """Return the bytes of a value."""
        return self._packers[number].size

    def read(self, number: int) -> bytes:
        """Return a value; what waits to be written counts already."""
        pending = self._pending.get(number)
        if pending is not None:
            return pending[0]
        start, end = self._places[number]
        return self._bytes[start:end].tobytes()

    def pack(self, number: int, value: float | int) -> bytes:
        """Return a value as bytes."""
        return self._packers[number].pack(value)

    def unpack(self, number: int, raw: bytes) -> float | int:
        """Return bytes of the right size as a value."""
        return self._packers[number].unpack(raw)[0]

    def write(self, number: int, raw: bytes) -> bool:
        """Have a value written.

        Args:
            number: A parameter that may be written.
            raw: Its new value, of the right size.

        Returns:
            False when it is refused, because it is not finite, or because too much waits already.
        """
        value = self.unpack(number, raw)
        if not math.isfinite(value):
            return False
        with self._lock:
            if self._waiting >= MAX_WAITING:
                return False
            self._waiting += 1
            self._pending[number] = (raw, self._pending.get(number, (raw, 0))[1] + 1)
        self._context.later(partial(self._carry_out, number, value), is_bounded=True)
        return True

    def _carry_out(self, number: int, value: float | int) -> None:
        try:
            self._context.drone.param[self._toc.variables[number].name] = value
        except CrazychoirError:
            pass  # the client hears of the value that stays
        finally:
            self._forget(number)

    def _forget(self, number: int) -> None:
        with self._lock:
            self._waiting -= 1
            raw, count = self._pending[number]
            if count > 1:
                self._pending[number] = (raw, count - 1)
            else:
                del self._pending[number]

    # ------------------------------------------------------------------- values as the client knows them

    def believe(self, number: int, raw: bytes) -> None:
        """Remember that this value was sent to the client."""
        part = self._parts[number]
        with self._lock:
            self._told_bytes[part] = raw
            self._is_told_bytes[part] = self._ones[number]
            self._has_told = True

    def forget_client(self) -> None:
        """Forget which values were sent to a client."""
        with self._lock:
            self._is_told[:] = False
            self._has_told = False

    def news(self) -> list[tuple[int, bytes]]:
        """Return numbers and values that differ from those sent to the client, and count them as sent."""
        if not self._has_told:
            return []
        with self._lock:
            present = self._memory[self._addresses]
            differs = (present != self._told) & self._is_told
            if not differs.any():
                return []
            changed = [number for number in np.unique(self._owners[differs]).tolist() if number not in self._pending]
            news = []
            for number in changed[:MAX_NEWS]:
                part = self._parts[number]
                self._told[part] = present[part]
                news.append((number, present[part].tobytes()))
            return news
