"""Reads and writes the binary log of the micro SD card deck.

The layout is isolated here. It is the published one of version 1 and 2 as we know it, and was not tested on a file from
a real card: all little-endian, ``0xBC``, then

    u16 version, u16 number of event types
    of each type: u16 id, its name and 0, u16 number of variables, of each ``name(code)`` and 0
    of each event: u16 id, time (version 1: u32 in ms, version 2: u64 in us), its variables without padding
    u32 CRC-32 of everything before it

where a code is one of the letters of Python's `struct`. A card that was pulled out has no CRC and half an event at its
end: what is whole is read, and a note says so.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.comparison.raw_log import MAX_BYTES, Array, RawLog

MAGIC = 0xBC
TIME = "timestamp_ms"
"""Name of the clock of each table (ms)."""

_CODES = "bBhHiIqQfd"
_CLOCKS = {1: ("<u4", 1.0), 2: ("<u8", 1e-3)}
_MAX_TYPES = 1000


@dataclass(frozen=True)
class _Kind:
    name: str
    dtype: np.dtype


def read_usd(path: Path) -> RawLog:
    """Return the events of a file, a table per type.

    Raises:
        RangeError: If it is no such file, or of another version.
    """
    try:
        if path.stat().st_size > MAX_BYTES:
            raise RangeError(f"{path.name}: longer than {MAX_BYTES} bytes")
        data = path.read_bytes()
    except OSError as error:
        raise RangeError(f"{path.name}: cannot be read: {error}") from error
    if not data or data[0] != MAGIC:
        raise RangeError(f"{path.name}: begins with {data[:1].hex() or 'nothing'}, but a card's log with bc")
    try:
        version, count = struct.unpack_from("<HH", data, 1)
        if version not in _CLOCKS:
            raise RangeError(f"{path.name}: is of version {version}, allowed: {', '.join(map(str, _CLOCKS))}")
        kinds, at = _kinds(data, min(count, _MAX_TYPES), 5, _CLOCKS[version][0])
    except (struct.error, ValueError, UnicodeDecodeError) as error:
        raise RangeError(f"{path.name}: its header is damaged: {error}") from error
    notes: list[str] = []
    end = len(data) - 4
    if len(data) < at + 4 or zlib.crc32(data[:-4]) != struct.unpack("<I", data[-4:])[0]:
        notes.append("the check sum at its end is missing or wrong: the card was pulled out, or the file is damaged")
        end = len(data)
    starts = _events(data, at, end, kinds, notes)
    tables = [_table(data, kinds[number], places, _CLOCKS[version][1]) for number, places in starts.items()]
    if not tables:
        raise RangeError(f"{path.name}: no events")
    return RawLog(path.stem, f"micro SD card, version {version}", tuple(tables), tuple(notes))


def _kinds(data: bytes, count: int, at: int, clock: str) -> tuple[dict[int, _Kind], int]:
    kinds = {}
    for _ in range(count):
        (number,) = struct.unpack_from("<H", data, at)
        name, at = _text(data, at + 2)
        (variables,) = struct.unpack_from("<H", data, at)
        at += 2
        fields: list[tuple[str, str]] = [(TIME, clock)]
        for _ in range(variables):
            text, at = _text(data, at)
            column, _, code = text.rpartition("(")
            if len(code) != 2 or code[0] not in _CODES:
                raise ValueError(f"variable {text[:40]!r} has no type")
            fields.append((column, np.dtype(f"<{code[0]}").str))
        kinds[number] = _Kind(name, np.dtype(fields))
    return kinds, at


def _text(data: bytes, at: int) -> tuple[str, int]:
    end = data.index(b"\0", at)
    return data[at:end].decode("utf-8"), end + 1


def _events(data: bytes, at: int, end: int, kinds: Mapping[int, _Kind], notes: list[str]) -> dict[int, list[int]]:
    """Return where the events of each type begin, behind their ids."""
    starts: dict[int, list[int]] = {}
    while at + 2 <= end:
        number = data[at] | data[at + 1] << 8
        kind = kinds.get(number)
        if kind is None:
            notes.append(f"unreadable from byte {at} on: there is no event type {number}")
            break
        if at + 2 + kind.dtype.itemsize > end:
            notes.append("its last event is cut off")
            break
        starts.setdefault(number, []).append(at + 2)
        at += 2 + kind.dtype.itemsize
    return starts


def _table(data: bytes, kind: _Kind, places: Sequence[int], scale: float) -> dict[str, Array]:
    size = kind.dtype.itemsize
    rows = np.frombuffer(b"".join(data[at : at + size] for at in places), kind.dtype)
    table = {name: rows[name].astype(float) for name in kind.dtype.names or ()}
    table[TIME] = table[TIME] * scale
    return table


def write_usd(path: Path, event: str, time_s: Array, columns: Mapping[str, Array]) -> None:
    """Write a file with one type of events, as a drone with a card does; all variables are floats.

    Args:
        path: The file.
        event: Name of the type, such as ``fixedFrequency``.
        time_s: Of the rows (s), shape (T,).
        columns: Values by name, (T,) each.
    """
    names = b"".join(f"{name}(f)".encode() + b"\0" for name in columns)
    head = struct.pack("<BHHH", MAGIC, 2, 1, 0) + event.encode() + b"\0" + struct.pack("<H", len(columns)) + names
    dtype = np.dtype([("id", "<u2"), ("time", "<u8"), *((name, "<f4") for name in columns)])
    rows = np.zeros(len(time_s), dtype)
    rows["time"] = np.rint(np.asarray(time_s) * 1e6)
    for name, values in columns.items():
        rows[name] = values
    body = head + rows.tobytes()
    path.write_bytes(body + struct.pack("<I", zlib.crc32(body)))
