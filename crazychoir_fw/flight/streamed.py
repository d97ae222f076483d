"""Has what a flight records written while it flies, at least once per second of the clock on the wall."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from crazychoir_fw.recording.log_stream import FLIGHT, LogStream

FLUSH_S = 0.5
"""Time between two writes (s): a flight that is killed loses no more, and a pause of the machine may double it."""


class Flushes:
    """Writes when it is time, between two rounds of a flight."""

    def __init__(self, stream: LogStream, flush: Callable[[], object], events: Callable[[], Sequence[Any]]) -> None:
        """Begin.

        Args:
            stream: Where to.
            flush: Moves the samples of the recorders there.
            events: Returns what happened so far beside the events of worlds (`WorldEvent`).
        """
        self._stream, self._flush, self._events = stream, flush, events
        self._written = 0
        self._due = time.monotonic()

    def look(self) -> None:
        """Write if it is time."""
        if time.monotonic() >= self._due:
            self.write()

    def write(self) -> None:
        """Write what is new."""
        events = self._events()
        if len(events) > self._written:
            self._stream.append_json(b"E", FLIGHT, [event.as_dict() for event in events[self._written :]])
            self._written = len(events)
        self._flush()
        self._stream.sync()
        self._due = time.monotonic() + FLUSH_S


def stream_flight(stream: LogStream, backend: Any, flight: Any, metadata: Mapping[str, Any]) -> Flushes:
    """Have a flight written to a stream.

    Args:
        stream: Where to.
        backend: Where the drones are.
        flight: What is flown.
        metadata: What its log says if it is cut off.
    """
    backend.write_to(stream, dict(metadata))
    return Flushes(stream, backend.flush, lambda: flight.events)
