"""Samples of a flight: rows of named fields, in memory until they are in a stream."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import DTypeLike, NDArray

from crazychoir_fw.recording.growing_block import GrowingBlock
from crazychoir_fw.recording.log_stream import Frame, StreamFile, fields_of

Column = Callable[[str], NDArray[Any]]
"""Returns a field of some samples, shape (rows, ...)."""

Fields = Mapping[str, tuple[Sequence[int], DTypeLike]]


class RowStore(Protocol):
    """Where rows go that have left memory: a `LogStream` or a `SpillFile`."""

    def append(self, kind: bytes, section: int, parts: Sequence[Any]) -> Frame | None:
        """Write rows; None: they are not taken."""

    def read_into(self, offset: int, rows: NDArray[Any]) -> None:
        """Read rows back."""


class Samples:
    """Rows of fields that each have one shape and type. Those that a stream has are not in memory."""

    def __init__(self, fields: Fields) -> None:
        """Begin without a row.

        Args:
            fields: Shape and type of each field of a row.
        """
        self._blocks = {name: GrowingBlock(shape, dtype) for name, (shape, dtype) in fields.items()}
        self._written: list[tuple[int, RowStore, int]] = []  # rows, and where they are
        self.row_bytes = sum(block.row_bytes for block in self._blocks.values())
        self._count = 0
        self._taken = 0  # rows of `free` that the blocks have not been told of

    def __len__(self) -> int:
        return self._count + len(next(iter(self._blocks.values()))) + self._taken

    @property
    def bytes_in_memory(self) -> int:
        """What the rows that no stream has take (bytes)."""
        return (len(self) - self._count) * self.row_bytes

    @property
    def description(self) -> list[list[Any]]:
        """The fields as plain data, for the header of a section."""
        return [[name, list(block.shape), block.dtype.str] for name, block in self._blocks.items()]

    def add(self) -> dict[str, NDArray[Any]]:
        """Return the fields of another row, to be filled."""
        self._settle()
        return {name: block.add() for name, block in self._blocks.items()}

    def free(self) -> dict[str, NDArray[Any]]:
        """Return the fields of rows behind the present ones, (rows, ...) each with the same number of rows.

        `take` makes the next one of them a row. They are the next ones until `free`, `add` or `write` is called.
        """
        self._settle()
        blocks = {name: block.free() for name, block in self._blocks.items()}
        count = min(map(len, blocks.values()))
        return {name: block[:count] for name, block in blocks.items()}

    def take(self, count: int = 1) -> None:
        """Take over the next of the rows that `free` returned; they are filled."""
        self._taken += count

    def _settle(self) -> None:
        for block in self._blocks.values():
            block.grow(self._taken)
        self._taken = 0

    def write(self, stream: RowStore, section: int) -> None:
        """Move the rows to a stream, and forget them; if it takes them not, they stay."""
        self._settle()
        rows = len(self) - self._count
        if not rows:
            return
        frame = stream.append(b"R", section, [piece for block in self._blocks.values() for piece in block.filled()])
        if frame is None:
            return
        self._written.append((rows, stream, frame.offset))
        self._count += rows
        for block in self._blocks.values():
            block.clear()

    def column(self, name: str) -> NDArray[Any]:
        """Return a field of all rows, shape (rows, ...)."""
        self._settle()
        block = self._blocks[name]
        column = np.empty((len(self), *block.shape), block.dtype)
        skipped = 0  # bytes of a row in fields before this one
        for other, each in self._blocks.items():
            if other == name:
                break
            skipped += each.row_bytes
        row = 0
        for count, stream, offset in self._written:
            stream.read_into(offset + skipped * count, column[row : row + count])
            row += count
        for piece in block.filled():
            column[row : row + len(piece)] = piece
            row += len(piece)
        return column


class StreamedSamples:
    """The same rows in a file that was read."""

    def __init__(self, file: StreamFile, section: int, header: Mapping[str, Any]) -> None:
        """Find the rows.

        Raises:
            ValueError: If frames are not made of whole rows.
        """
        self._file = file
        self._fields = fields_of(header)
        self._row_bytes = sum(math.prod(shape) * dtype.itemsize for shape, dtype in self._fields.values())
        self._frames = file.of(b"R", section)
        if any(not self._row_bytes or frame.size % self._row_bytes for frame in self._frames):
            raise ValueError("a frame is not made of whole rows")

    def __len__(self) -> int:
        return sum(frame.size // self._row_bytes for frame in self._frames)

    def column(self, name: str) -> NDArray[Any]:
        """See `Samples.column`.

        Raises:
            KeyError: If there is no such field.
        """
        return self._column(name, self._frames)

    def _column(self, name: str, frames: Sequence[Frame]) -> NDArray[Any]:
        shape, dtype = self._fields[name]
        skipped = 0
        for other, (sizes, kind) in self._fields.items():
            if other == name:
                break
            skipped += math.prod(sizes) * kind.itemsize
        pieces = [np.empty((0, *shape), dtype)]
        for frame in frames:
            count = frame.size // self._row_bytes
            begin, size = skipped * count, math.prod(shape) * dtype.itemsize * count
            pieces.append(self._file.payload(frame, begin, size).view(dtype).reshape(count, *shape))
        return np.concatenate(pieces)

    def chunks(self, size: int) -> Iterator[tuple[int, Column]]:
        """Give all rows in turn, in groups of whole frames of about a size (bytes): how many, and their columns."""
        group: list[Frame] = []
        for frame in self._frames:
            if group and sum(one.size for one in group) + frame.size > size:
                yield self._group(group)
                group = []
            group.append(frame)
        if group:
            yield self._group(group)

    def _group(self, frames: list[Frame]) -> tuple[int, Column]:
        count = sum(frame.size for frame in frames) // self._row_bytes
        return count, lambda name: self._column(name, frames)
