"""What one recorder writes into a stream: a header once, then rows, requests and events as they come."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.recording.journal import Journal
from crazychoir_fw.recording.log_stream import Frame, LogStream
from crazychoir_fw.recording.samples import Samples

TAKEN_BACK = "the world was taken back in time while it was recorded"

_ABOUT = struct.Struct("<I")
_COLUMNS = {"ticks": np.int64, "drones": np.int32, "kinds": np.int32, "numbers": np.float64, "blob": np.uint8}


class RecordOutput:
    """One section of a stream."""

    def __init__(self, stream: LogStream, metadata: Mapping[str, Any]) -> None:
        """Take a section.

        Args:
            stream: Whose.
            metadata: What a log says that is cut off.
        """
        self._stream = stream
        self._section = stream.section()
        self._metadata = dict(metadata)
        self._has_begun = False
        self._events = 0
        self._journal: Journal | None = None  # whose requests are written
        self._gap: str | None = None
        self._requests: list[Frame] = []

    @property
    def path(self) -> Path:
        """The file of the stream."""
        return self._stream.path

    @property
    def is_complete(self) -> bool:
        """Whether everything is in the stream that `write` was given."""
        return self._stream.failure is None

    def begin(
        self,
        layout: Mapping[str, Any],
        samples: Samples,
        drones: Sequence[str],
        recipe: Mapping[str, Any] | None = None,
    ) -> None:
        """Write the header, if it is not yet."""
        if self._has_begun:
            return
        header = {
            "layout": dict(layout),
            "fields": samples.description,
            "drones": list(drones),
            "metadata": self._metadata,
            "recipe": recipe,
        }
        self._has_begun = self._stream.append_json(b"H", self._section, header) is not None

    def write(self, samples: Samples, journal: Journal | None = None, events: Sequence[Mapping[str, Any]] = ()) -> None:
        """Write what is new. Requests come before the rows that count them."""
        if len(events) > self._events:
            self._stream.append_json(b"E", self._section, list(events[self._events :]))
            self._events = len(events)
        if journal is not None:
            self._write_requests(journal)
        samples.write(self._stream, self._section)

    def _write_requests(self, journal: Journal) -> None:
        """Write the requests of a journal, and have it forget them."""
        if journal is not self._journal:
            self._gap = None if self._journal is None else TAKEN_BACK
            self._journal, self._requests = journal, []
        gap = journal.gap or self._gap
        if len(journal) == journal.forgotten and self._requests and gap is None:
            return
        columns = journal.to_arrays()
        about = json.loads(str(columns["about"]))
        head = json.dumps({**about, "recipe": None, "gap": gap, "skipped": journal.forgotten}).encode()
        parts = [_ABOUT.pack(len(head)), head, *(columns[name] for name in _COLUMNS)]
        frame = self._stream.append(b"J", self._section, parts)
        if frame is not None:
            self._requests.append(frame)
            journal.forget()

    def journal(self, journal: Journal) -> Journal:
        """Return a copy of a journal with the requests that it has forgotten."""
        if journal is not self._journal or not journal.forgotten:
            return journal.copy()
        whole = Journal(journal.recipe)
        for frame in self._requests:
            payload = np.empty(frame.size, np.uint8)
            self._stream.read_into(frame.offset, payload)
            whole.extend(requests_of(payload, trusted=True))
        whole.extend(journal.copy())
        whole.gap, whole.is_kept = journal.gap, journal.is_kept
        return whole


def requests_of(payload: NDArray[np.uint8], trusted: bool = False) -> Journal:
    """Return the requests of a frame as a journal without a recipe.

    Args:
        payload: Of the frame.
        trusted: Whether this process wrote it.

    Raises:
        ValueError: If it holds none.
        KeyError: If something of it is missing.
    """
    (size,) = _ABOUT.unpack(payload[: _ABOUT.size].tobytes())
    about = json.loads(payload[_ABOUT.size : _ABOUT.size + size].tobytes())
    rest = payload[_ABOUT.size + size :]
    numbers, blob = sum(map(int, about["numbers"])), sum(map(int, about["bytes"]))
    count = (len(rest) - 8 * numbers - blob) // 16
    sizes = {"ticks": count, "drones": count, "kinds": count, "numbers": numbers, "blob": blob}
    arrays: dict[str, NDArray[Any]] = {"about": np.array(json.dumps(about)), "samples": np.zeros(0, np.int64)}
    for name, dtype in _COLUMNS.items():
        length = sizes[name] * np.dtype(dtype).itemsize
        arrays[name], rest = rest[:length].view(dtype), rest[length:]
    if len(rest) or count < 0:
        raise ValueError("the requests of a frame are cut off")
    journal = Journal.from_arrays(arrays, trusted)
    journal.forgotten = int(about["skipped"])
    return journal
