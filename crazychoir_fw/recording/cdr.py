"""Messages of equal size in CDR, the encoding of ROS 2, written by the column.

All messages of one topic differ in numbers only, so that their bytes are one NumPy array: a thousand messages cost as
little as one.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

_ENCAPSULATION = b"\x00\x01\x00\x00"  # CDR, little-endian


class CdrLayout:
    """Where the numbers of a message stand. Members are appended in the order of the message definition."""

    def __init__(self) -> None:
        self._bytes = bytearray(_ENCAPSULATION)
        self._names: list[str] = []
        self._formats: list[Any] = []
        self._offsets: list[int] = []

    def _align(self, size: int) -> None:
        # counted from behind the encapsulation
        self._bytes += bytes(-(len(self._bytes) - len(_ENCAPSULATION)) % size)

    def number(self, name: str, dtype: str, count: int = 1, value: float = 0) -> CdrLayout:
        """Append a number, or an array of a fixed length, that differs between messages."""
        kind = np.dtype(dtype).newbyteorder("<")
        self._align(kind.itemsize)
        self._names.append(name)
        self._formats.append(kind if count == 1 else (kind, (count,)))
        self._offsets.append(len(self._bytes))
        self._bytes += np.full(count, value, kind).tobytes()
        return self

    def constant(self, dtype: str, *values: float) -> CdrLayout:
        """Append numbers that are the same in all messages."""
        kind = np.dtype(dtype).newbyteorder("<")
        self._align(kind.itemsize)
        self._bytes += np.array(values, kind).tobytes()
        return self

    def text(self, value: str) -> CdrLayout:
        """Append a text that is the same in all messages."""
        raw = value.encode() + b"\0"
        self.constant("u4", len(raw))
        self._bytes += raw
        return self

    def stamp(self, frame: str | None = None) -> CdrLayout:
        """Append a time stamp (`set_stamps`), and where there is a frame, its name: a ``std_msgs/Header``."""
        self.number("sec", "i4").number("nanosec", "u4")
        return self if frame is None else self.text(frame)

    def rows(self, count: int) -> NDArray[Any]:
        """Return messages to be filled in, a structured array of shape (count,)."""
        dtype = np.dtype(
            {
                "names": self._names,
                "formats": self._formats,
                "offsets": self._offsets,
                "itemsize": len(self._bytes),
            }
        )
        template = np.frombuffer(bytes(self._bytes), np.uint8)
        return np.tile(template, count).view(dtype)


def set_stamps(rows: NDArray[Any], nanoseconds: NDArray[np.int64]) -> None:
    """Fill in the time stamps of messages."""
    rows["sec"], rows["nanosec"] = np.divmod(nanoseconds, 1_000_000_000)
