"""Rows of a long flight without a log stream, in an unnamed temporary file instead of in memory."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from io import FileIO
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from crazychoir_fw.recording.log_stream import Frame, read_fully, write_fully


class SpillFile:
    """Takes the place of a `LogStream` for `Samples`; the file is gone with the process."""

    def __init__(self) -> None:
        """Begin without a file; the folder is that of `tempfile`."""
        self._file: FileIO | None = None
        self._end = 0
        self._has_failed = False

    def append(self, kind: bytes, section: int, parts: Sequence[Any]) -> Frame | None:
        """Write rows behind each other.

        Returns:
            Where they are; None when the disk does not take them, which is not tried again.
        """
        if self._has_failed:
            return None
        begin = self._end
        try:
            if self._file is None:
                number, name = tempfile.mkstemp(prefix="crazychoir-")
                self._file = FileIO(number, "r+")
                Path(name).unlink()
            for part in parts:
                self._end = write_fully(self._file.fileno(), part, self._end)
        except OSError:
            self._end, self._has_failed = begin, True
            if self._file is not None:
                with suppress(OSError):
                    os.ftruncate(self._file.fileno(), begin)
            return None
        return Frame(kind, section, begin, self._end - begin)

    def read_into(self, offset: int, rows: NDArray[Any]) -> None:
        """See `LogStream.read_into`."""
        assert self._file is not None
        read_fully(self._file.fileno(), offset, rows)
