"""A flight log as an MCAP file with ROS 2 messages, for Foxglove, PlotJuggler and rosbag tools."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from crazychoir_fw.common.errors import MissingLibraryError
from crazychoir_fw.common.replacing import replacing
from crazychoir_fw.common.version import __version__
from crazychoir_fw.recording.flight_log import FlightLog

if TYPE_CHECKING:
    from mcap.writer import Writer

    from crazychoir_fw.recording.mcap_topics import Topic

EVENTS = "/events"
SAMPLES_AT_A_TIME = 200
"""So many samples of all drones are in memory as messages."""


def write_mcap(log: FlightLog, path: str | Path) -> None:
    """Write a log as an MCAP file; *path* is replaced in one step, or left alone if writing fails.

    Time stamps are simulated time, from 0. Topics whose signals the log does not have are left out.

    Raises:
        MissingLibraryError: If the libraries that write such files are not installed.
    """
    require_mcap()
    from mcap.writer import CompressionType, Writer

    with replacing(Path(path)) as temporary, temporary.open("wb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD)
        writer.start(profile="ros2", library=f"crazychoir-fw {__version__}")
        _File(log, writer).write()
        writer.finish()


def require_mcap() -> None:
    """Return if MCAP files can be written here.

    Raises:
        MissingLibraryError: If a library for it is not installed.
    """
    try:
        import mcap.writer  # noqa: F401
        import rosbags.typesys  # noqa: F401
    except ImportError:
        raise MissingLibraryError(
            "MCAP files need the packages mcap and rosbags: run pip install 'crazychoir-fw[mcap]'"
        ) from None


class _Stream(NamedTuple):
    """The messages of one drone on one topic."""

    topic: Topic
    column: int
    drone: str
    channel: int


class _File:
    """One file while it is written."""

    def __init__(self, log: FlightLog, writer: Writer) -> None:
        from rosbags.typesys import Stores, get_typestore

        self._log = log
        self._writer = writer
        self._types = get_typestore(Stores.ROS2_JAZZY)
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}

    def write(self) -> None:
        """Write what the log says of itself, then all messages in the order of time."""
        facts = {key: value for key, value in self._log.metadata.items() if isinstance(value, str | int | float)}
        self._writer.add_metadata("crazychoir_fw", {key: str(value) for key, value in facts.items()})
        streams = list(self._streams())
        events = self._events()
        event = next(events, None)
        stamps = np.rint(self._log.time * 1e9).astype(np.int64).tolist()
        for begin in range(0, len(stamps), SAMPLES_AT_A_TIME):
            now = stamps[begin : begin + SAMPLES_AT_A_TIME]
            for stamp, *messages in zip(now, *(self._samples(stream, begin, now) for stream in streams), strict=True):
                while event is not None and event[1] <= stamp:
                    self._add(*event)
                    event = next(events, None)
                for stream, message in zip(streams, messages, strict=True):
                    self._add(stream.channel, stamp, message)
        while event is not None:
            self._add(*event)
            event = next(events, None)

    def _add(self, channel: int, stamp: int, message: Any) -> None:
        data = bytes(self._types.serialize_cdr(message, message.__msgtype__))
        self._writer.add_message(channel_id=channel, log_time=stamp, publish_time=stamp, data=data)

    def _events(self) -> Iterator[tuple[int, int, Any]]:
        from crazychoir_fw.recording.mcap_topics import Log, event_message

        for event in sorted(self._log.events, key=lambda event: event["time"]):
            stamp = round(event["time"] * 1e9)
            yield self._channel(EVENTS, Log), stamp, event_message(event, stamp)

    def _streams(self) -> Iterator[_Stream]:
        from crazychoir_fw.recording.mcap_topics import TOPICS, TRANSFORM

        for column, drone in enumerate(self._log.drone_ids):
            for topic in (*TOPICS, TRANSFORM):
                if self._has(topic, column):
                    name = topic.name if topic is TRANSFORM else f"/{drone}/{topic.name}"
                    yield _Stream(topic, column, drone, self._channel(name, topic.type))

    def _has(self, topic: Topic, column: int) -> bool:
        """Return whether the log has what a topic of a drone needs; a column of NaN belongs to other drones."""
        signals = self._log.signals
        return all(name in signals and not np.all(np.isnan(signals[name][:, column])) for name in topic.needs)

    def _channel(self, topic: str, kind: Any) -> int:
        name = kind.__msgtype__
        if name not in self._schemas:
            text, _ = self._types.generate_msgdef(name, ros_version=2)
            self._schemas[name] = self._writer.register_schema(name, "ros2msg", text.encode())
        if topic not in self._channels:
            self._channels[topic] = self._writer.register_channel(topic, "cdr", self._schemas[name])
        return self._channels[topic]

    def _samples(self, stream: _Stream, begin: int, stamps: list[int]) -> Iterator[Any]:
        """Return some samples of a stream as messages."""

        def of(name: str) -> np.ndarray:
            if name not in self._log.signals:
                return np.full(len(stamps), np.nan)
            return self._log.signals[name][begin : begin + len(stamps), stream.column].astype(np.float64)

        return stream.topic.messages(stamps, stream.drone, of)
