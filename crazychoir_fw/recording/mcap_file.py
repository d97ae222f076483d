"""A flight log as an MCAP file with ROS 2 messages, for Foxglove, PlotJuggler and rosbag tools."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import MissingLibraryError
from crazychoir_fw.common.replacing import replacing
from crazychoir_fw.common.version import __version__
from crazychoir_fw.recording.cdr import set_stamps
from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.recording.mcap_topics import TOPICS, TRANSFORM, Topic, event_message
from crazychoir_fw.recording.ros2_schemas import schema_name, schema_text

if TYPE_CHECKING:
    from mcap.writer import Writer

EVENTS = "/events"
SAMPLES_AT_A_TIME = 200
"""So many samples of all drones are in memory as messages."""


def write_mcap(log: FlightLog, path: str | Path) -> None:
    """Write a log as an MCAP file; *path* is replaced in one step, or left alone if writing fails.

    Time stamps are simulated time, from 0. Topics whose signals the log does not have are left out.

    Raises:
        MissingLibraryError: If the library that writes such files is not installed.
    """
    writer_type, compression = _library()
    with replacing(Path(path)) as temporary, temporary.open("wb") as file:
        writer = writer_type(file, compression=compression)
        writer.start(profile="ros2", library=f"crazychoir-fw {__version__}")
        _File(log, writer).write()
        writer.finish()


def require_mcap() -> None:
    """Return if MCAP files can be written here.

    Raises:
        MissingLibraryError: If the library for it is not installed.
    """
    _library()


def _library() -> tuple[Callable[..., Writer], Any]:
    try:
        from mcap.writer import CompressionType, Writer
    except ImportError:
        raise MissingLibraryError("MCAP files need the package mcap: run pip install 'crazychoir-fw[mcap]'") from None
    return Writer, CompressionType.ZSTD


class _Stream:
    """The messages of one drone on one topic."""

    def __init__(self, topic: Topic, column: int, drone: str, channel: int) -> None:
        self.topic = topic
        self.column = column
        self.layout = topic.layout(drone)
        self.channel = channel


class _File:
    """One file while it is written."""

    def __init__(self, log: FlightLog, writer: Writer) -> None:
        self._log = log
        self._writer = writer
        self._nanoseconds = np.rint(log.time * 1e9).astype(np.int64)
        self._schemas: dict[str, int] = {}

    def write(self) -> None:
        """Write what the log says of itself, then all messages in the order of time."""
        facts = {key: value for key, value in self._log.metadata.items() if isinstance(value, str | int | float)}
        self._writer.add_metadata("crazychoir_fw", {key: str(value) for key, value in facts.items()})
        streams = list(self._streams())
        events = iter(sorted(self._log.events, key=lambda event: event["time"]))
        channel = self._channel(EVENTS, "rcl_interfaces/Log") if self._log.events else 0
        event = next(events, None)
        for begin in range(0, len(self._log.time), SAMPLES_AT_A_TIME):
            stamps = self._nanoseconds[begin : begin + SAMPLES_AT_A_TIME]
            messages = [self._messages(stream, begin, stamps) for stream in streams]
            for i, stamp in enumerate(stamps.tolist()):
                while event is not None and round(event["time"] * 1e9) <= stamp:
                    self._write_event(channel, event)
                    event = next(events, None)
                for stream, (raw, size) in zip(streams, messages, strict=True):
                    self._add(stream.channel, stamp, raw[i * size : (i + 1) * size])
        while event is not None:
            self._write_event(channel, event)
            event = next(events, None)

    def _add(self, channel: int, stamp: int, data: bytes) -> None:
        self._writer.add_message(channel_id=channel, log_time=stamp, publish_time=stamp, data=data)

    def _write_event(self, channel: int, event: dict[str, Any]) -> None:
        stamp = round(event["time"] * 1e9)
        self._add(channel, stamp, event_message(event, stamp))

    def _streams(self) -> Iterator[_Stream]:
        transforms = None
        for column, drone in enumerate(self._log.drone_ids):
            for topic in TOPICS:
                if self._has(topic, column):
                    yield _Stream(topic, column, drone, self._channel(f"/{drone}/{topic.name}", topic.message))
            if self._has(TRANSFORM, column):
                if transforms is None:
                    transforms = self._channel(TRANSFORM.name, TRANSFORM.message)
                yield _Stream(TRANSFORM, column, drone, transforms)

    def _has(self, topic: Topic, column: int) -> bool:
        """Return whether the log has what a topic of a drone needs; a column of NaN belongs to other drones."""
        signals = self._log.signals
        return all(name in signals and not np.all(np.isnan(signals[name][:, column])) for name in topic.needs)

    def _channel(self, topic: str, message: str) -> int:
        if message not in self._schemas:
            text = schema_text(message).encode()
            self._schemas[message] = self._writer.register_schema(schema_name(message), "ros2msg", text)
        return self._writer.register_channel(topic, "cdr", self._schemas[message])

    def _messages(self, stream: _Stream, begin: int, stamps: NDArray[np.int64]) -> tuple[bytes, int]:
        """Return the messages of some samples one behind the other, and the length of one (bytes)."""
        rows = stream.layout.rows(len(stamps))
        set_stamps(rows, stamps)
        end = begin + len(stamps)

        def samples(name: str) -> NDArray[np.float64]:
            if name not in self._log.signals:
                return np.full(len(stamps), np.nan)
            return self._log.signals[name][begin:end, stream.column].astype(np.float64)

        stream.topic.fill(rows, samples)
        return rows.tobytes(), rows.dtype.itemsize
