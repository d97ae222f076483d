"""The log of a flight while it flies: an append-only file, from which `log.npz` is made at an orderly end.

The file is a line that names the format, and frames behind it: kind, section, length and CRC of the payload, and the
payload. A section is what one recorder writes: a header (JSON), rows of its fields as they are in memory, field by
field, requests of the journal, events. A process that is killed leaves whole frames and at most one that is torn.
"""

from __future__ import annotations

import fcntl
import io
import json
import os
import struct
import threading
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import StateError

STREAM = "log.stream"
"""Name of the file in the folder of a flight."""

_MAGIC = b"crazychoir log stream 1\n"
_FRAME = struct.Struct("<cBxxII")  # kind, section, length and CRC-32 of the payload
_MAX_FRAME = 1 << 30  # [bytes]
_PIECE = 1 << 22  # [bytes], of a frame that is looked at only
FLIGHT = 255
"""Section of what belongs to no recorder: events of the layers, and how the sections are one swarm."""


class Frame(NamedTuple):
    """Where a payload is in the file."""

    kind: bytes
    """``H`` header, ``R`` rows, ``J`` journal, ``E`` events."""
    section: int
    offset: int
    """Of the payload (bytes)."""
    size: int


def write_fully(file: int, part: Any, offset: int) -> int:
    """Write contiguous memory into a file at an offset (bytes), and return the offset behind it."""
    view = memoryview(part)
    if view.nbytes:
        view = view.cast("B")
    while view:
        count = os.pwrite(file, view, offset)
        view, offset = view[count:], offset + count
    return offset


def read_fully(file: int, offset: int, rows: NDArray[Any]) -> None:
    """Fill contiguous memory out of a file, from an offset (bytes) on.

    Raises:
        OSError: If the file ends before.
    """
    view = memoryview(rows.data).cast("B") if rows.nbytes else memoryview(b"")
    while view:
        count = os.preadv(file, [view], offset)
        if count == 0:
            raise OSError("the log was cut by another process")
        view, offset = view[count:], offset + count


class LogStream:
    """Appends frames to a file. A frame that cannot be written is no error of the flight: `failure` says why."""

    def __init__(self, path: Path) -> None:
        """Begin the file; one that a killed process left is replaced.

        Raises:
            OSError: If it cannot be written.
            StateError: If another process is writing it.
        """
        self.path = Path(path)
        self.failure: str | None = None
        """Why writing has stopped, as a sentence."""
        self.has_rows = False
        """Whether there is a sample in it."""
        self._sections = 0
        self._end = 0
        self._file = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(self._file)
            raise StateError(f"{self.path} is being written by another flight; choose another folder") from None
        self._is_due, self._is_closed = threading.Event(), False
        self._syncing: threading.Thread | None = None
        try:
            os.ftruncate(self._file, 0)
            self._write([_MAGIC])
        except OSError:
            self.close()
            raise

    def section(self) -> int:
        """Return the number of another section."""
        self._sections += 1
        return self._sections - 1

    def append(self, kind: bytes, section: int, parts: Sequence[Any]) -> Frame | None:
        """Write a frame; kill -9 loses nothing of it from now on.

        Args:
            kind: See `Frame`.
            section: Whose it is.
            parts: The payload in pieces, each contiguous memory.

        Returns:
            Where the payload is; None when it is not, see `failure`.
        """
        if self.failure is not None:
            return None
        views = [memoryview(part).cast("B") for part in parts if memoryview(part).nbytes]
        size, check = sum(view.nbytes for view in views), 0
        for view in views:
            check = zlib.crc32(view, check)
        begin = self._end
        try:
            if size > _MAX_FRAME:
                raise OSError(f"{size} bytes are too many for a frame")
            self._write([_FRAME.pack(kind, section, size, check), *views])
        except BaseException as error:  # Ctrl-C as well: what comes next takes the place of a torn frame
            self._end = begin
            with suppress(OSError):
                os.ftruncate(self._file, begin)
            if not isinstance(error, OSError):
                raise
            self.failure = f"{self.path} cannot be written: {error.strerror or error}"
            return None
        self.has_rows |= kind == b"R"
        return Frame(kind, section, begin + _FRAME.size, size)

    def append_json(self, kind: bytes, section: int, value: Any) -> Frame | None:
        """Write a frame of plain data."""
        return self.append(kind, section, [json.dumps(value, default=str).encode()])

    def read_into(self, offset: int, rows: NDArray[Any]) -> None:
        """Read back what was written.

        Args:
            offset: Where (bytes).
            rows: What is filled, contiguous.
        """
        read_fully(self._file, offset, rows)

    def sync(self) -> None:
        """Have the disk keep what is written, through a power cut as well; another thread waits for the disk."""
        if self._syncing is None:
            self._syncing = threading.Thread(target=self._sync, name="log-stream", daemon=True)
            self._syncing.start()
        self._is_due.set()

    def close(self, remove: bool = False) -> None:
        """Stop writing.

        Args:
            remove: Whether the file is removed, because its content is elsewhere.
        """
        if self._is_closed:
            return
        self._is_closed = True
        self._is_due.set()
        if self._syncing is not None:
            self._syncing.join()
        if remove:
            self.path.unlink(missing_ok=True)
        os.close(self._file)

    def _write(self, parts: Iterable[Any]) -> None:
        for part in parts:
            self._end = write_fully(self._file, part, self._end)

    def _sync(self) -> None:
        while not self._is_closed:
            self._is_due.wait()
            self._is_due.clear()
            try:
                os.fdatasync(self._file)
            except OSError as error:
                self.failure = self.failure or f"{self.path} cannot be written: {error.strerror}"


class StreamFile:
    """The whole frames of a stream, read only; it may still be written."""

    def __init__(self, path: Path) -> None:
        """Find the frames.

        Raises:
            OSError: If the file cannot be read.
            ValueError: If it is no stream.
        """
        self.is_torn = False
        """Whether something follows the last whole frame."""
        # not mapped: pages of a map count as memory of the process, and a file that becomes shorter would end it
        self._file = io.FileIO(path)
        self._size = Path(path).stat().st_size
        if self._size < len(_MAGIC) or self._read(0, len(_MAGIC)).tobytes() != _MAGIC:
            raise ValueError("it is no stream of a log")
        self.frames = list(self._scan())

    def _scan(self) -> Iterator[Frame]:
        at, end = len(_MAGIC), self._size
        while at < end:
            if at + _FRAME.size > end:
                break
            kind, section, size, check = _FRAME.unpack(self._read(at, _FRAME.size).data)
            frame = Frame(kind, section, at + _FRAME.size, size)
            if frame.offset + size > end or self._check(frame) != check:
                break
            yield frame
            at = frame.offset + size
        self.is_torn = at < end

    def _check(self, frame: Frame) -> int:
        """Return the CRC-32 of a payload."""
        check = 0
        for begin in range(0, frame.size, _PIECE):
            check = zlib.crc32(self.payload(frame, begin, min(_PIECE, frame.size - begin)).data, check)
        return check

    def _read(self, offset: int, size: int) -> NDArray[np.uint8]:
        data = np.empty(size, np.uint8)
        view = memoryview(data.data) if size else memoryview(b"")
        while view:
            count = os.preadv(self._file.fileno(), [view], offset)
            if count == 0:
                raise ValueError("it was cut while it was read")
            view, offset = view[count:], offset + count
        return data

    def payload(self, frame: Frame, begin: int = 0, size: int | None = None) -> NDArray[np.uint8]:
        """Return bytes of a frame.

        Args:
            frame: Which one.
            begin: Where in its payload (bytes).
            size: How many; None is all from there.

        Raises:
            ValueError: If the file has become shorter.
        """
        return self._read(frame.offset + begin, frame.size - begin if size is None else size)

    def of(self, kind: bytes, section: int) -> list[Frame]:
        """Return the frames of one kind of a section, in their order."""
        return [frame for frame in self.frames if frame.kind == kind and frame.section == section]

    def json(self, frame: Frame) -> Any:
        """Return plain data.

        Raises:
            ValueError: If it is none.
        """
        return json.loads(self.payload(frame).tobytes())


def fields_of(header: Mapping[str, Any]) -> dict[str, tuple[tuple[int, ...], np.dtype]]:
    """Return shape and type of each field of a row.

    Raises:
        ValueError: If they are no numbers.
    """
    fields = {}
    for name, shape, kind in header["fields"]:
        dtype, sizes = np.dtype(str(kind)), tuple(int(size) for size in shape)
        if dtype.kind not in "biuf" or any(size < 0 for size in sizes):
            raise ValueError(f"field {name} is {dtype} of shape {sizes}, expected numbers")
        fields[str(name)] = sizes, dtype
    return fields
