"""Reads MCAP files with ROS 2 messages, and rosbag2 folders: every number of every message is a column.

A column is called by topic and field: ``odom.pose.pose.position.x`` of the topic ``/cf1/odom`` of drone ``cf1``. Lists
of up to 16 numbers have one column per place (``motors.effort.0``). The clock of a table is ``time`` (s): the header's
stamp, or where there is none when the message was recorded.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from crazychoir_fw.common.errors import MissingLibraryError, RangeError
from crazychoir_fw.comparison.raw_log import Array, RawLog

TIME = "time"
_MAX_LIST = 16
_MAX_DEPTH = 6
_MAX_MESSAGES = 3_000_000

Message = tuple[str, int, Any]
"""Topic, when it was recorded (ns), and the message."""


def read_ros(path: Path, drone: str | None) -> RawLog:
    """Return the numbers of a recording.

    Args:
        path: An ``.mcap`` file, or a folder of rosbag2.
        drone: Whose topics: those that begin with ``/NAME/``; None takes the first drone in it.

    Raises:
        MissingLibraryError: If the libraries that read such files are not installed.
        RangeError: If it cannot be read, has no numbers, or none of this drone.
    """
    notes: list[str] = []
    messages = _bag(path, notes) if path.is_dir() else _mcap(path, notes)
    topics: dict[str, list[tuple[int, dict[str, float]]]] = {}
    try:
        for count, (topic, stamp, message) in enumerate(messages):
            if count > _MAX_MESSAGES:
                raise RangeError(f"{path.name}: has more than {_MAX_MESSAGES} messages")
            numbers = dict(_numbers("", message, 0))
            if numbers:
                topics.setdefault(topic, []).append((_stamp(message, stamp), numbers))
    except (RangeError, MissingLibraryError):
        raise
    except Exception as error:  # a damaged file makes its readers raise whatever they can
        if not topics:
            raise RangeError(f"{path.name}: cannot be read: {error or type(error).__name__}") from error
        notes.append(f"unreadable from its middle on: {error or type(error).__name__}")
    if not topics:
        raise RangeError(f"{path.name}: no messages with numbers")
    chosen = _of_drone(topics, drone, path.name)
    tables = tuple(_table(name, topics[topic]) for topic, name in chosen.items())
    return RawLog(path.stem, "rosbag2" if path.is_dir() else "MCAP", tables, tuple(dict.fromkeys(notes)))


def _types() -> Any:
    try:
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise MissingLibraryError(
            "MCAP files and rosbags need the packages mcap and rosbags: run pip install 'crazychoir-fw[mcap]'"
        ) from None
    return get_typestore(Stores.ROS2_JAZZY)


def _mcap(path: Path, notes: list[str]) -> Iterator[Message]:
    types = _types()
    from mcap.reader import make_reader

    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages(log_time_order=False):
            if schema is None or channel.message_encoding != "cdr":
                notes.append(f"topic {channel.topic} is in {channel.message_encoding}, allowed: cdr")
                continue
            _learn(types, schema.name, schema.data.decode("utf-8", "replace"))
            yield channel.topic, message.log_time, types.deserialize_cdr(message.data, schema.name)


def _bag(path: Path, notes: list[str]) -> Iterator[Message]:
    types = _types()
    from rosbags.rosbag2 import Reader

    with Reader(path) as reader:
        for connection in reader.connections:
            definition = connection.msgdef
            _learn(types, connection.msgtype, str(getattr(definition, "data", definition) or ""))
        known = [connection for connection in reader.connections if connection.msgtype in types.fielddefs]
        unknown = {connection.topic for connection in reader.connections} - {each.topic for each in known}
        notes += [f"topic {topic} has a type without a definition" for topic in sorted(unknown)]
        for connection, stamp, data in reader.messages(connections=known):
            yield connection.topic, stamp, types.deserialize_cdr(data, connection.msgtype)


def _learn(types: Any, name: str, definition: str) -> None:
    """Take the definition of a type that the store does not have from the file."""
    if name in types.fielddefs or not definition:
        return
    from rosbags.typesys import get_types_from_msg

    types.register(get_types_from_msg(definition, name))


def _stamp(message: Any, recorded: int) -> int:
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    return recorded if stamp is None else int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def _numbers(prefix: str, value: Any, depth: int) -> Iterator[tuple[str, float]]:
    if isinstance(value, bool | int | float | np.number):
        yield prefix, float(value)
    elif isinstance(value, np.ndarray | list | tuple):
        if len(value) <= _MAX_LIST:
            for place, item in enumerate(value):
                yield from _numbers(f"{prefix}.{place}", item, depth + 1)
    elif depth < _MAX_DEPTH and hasattr(value, "__dataclass_fields__"):
        for name in value.__dataclass_fields__:
            if not name.startswith("__") and name != "header":
                yield from _numbers(f"{prefix}.{name}" if prefix else name, getattr(value, name), depth + 1)


def _of_drone(topics: Iterable[str], drone: str | None, name: str) -> dict[str, str]:
    """Return the topics of one drone, and those of none, with the names that their columns begin with."""
    parts = {topic: topic.strip("/").split("/") for topic in topics}
    drones = list(dict.fromkeys(part[0] for part in parts.values() if len(part) > 1))
    if drone is not None and drones and drone not in drones:
        raise RangeError(f"{name}: has no topics of drone '{drone}', but of {', '.join(drones)}")
    chosen = drone if drone is not None else next(iter(drones), None)
    own = {topic: ".".join(part[1:]) for topic, part in parts.items() if len(part) > 1 and part[0] == chosen}
    return own or {topic: ".".join(part) for topic, part in parts.items()}


def _table(name: str, rows: list[tuple[int, dict[str, float]]]) -> dict[str, Array]:
    columns = list(dict.fromkeys(column for _, numbers in rows for column in numbers))
    table = {f"{name}.{column}": np.array([row.get(column, np.nan) for _, row in rows]) for column in columns}
    first = rows[0][0]
    # seconds since 1970 leave a float 0.2 us: enough
    return {TIME: first * 1e-9 + np.array([(stamp - first) * 1e-9 for stamp, _ in rows]), **table}
