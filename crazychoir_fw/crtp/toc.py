"""Tables of contents as clients fetch them: what there is, by number, and a checksum of all of it.

Logs and parameters answer alike (docs/reference/crtp-cflib.md#8.1, #8.4 and #9.2); every reply is made beforehand.
"""

from __future__ import annotations

import functools
import struct
import zlib
from collections.abc import Mapping
from typing import NamedTuple

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.onboard.variables import Variable, log_table, parameter_table

ITEM_V1, INFO_V1, ITEM, INFO = range(4)
"""First byte of a request on channel 0."""

MAX_NAME = 24
"""Characters in group and name together, so that an item fits into a packet."""

LOG_TYPES = {"u1": 1, "u2": 2, "u4": 3, "i1": 4, "i2": 5, "i4": 6, "f4": 7}
"""Type bytes of log variables, by the type on the drone."""

PARAMETER_TYPES = {"u1": 0x08, "u2": 0x09, "u4": 0x0A, "i1": 0x00, "i2": 0x01, "i4": 0x02, "f4": 0x06}
"""Type bytes of parameters without flags, by the type on the drone."""

EXTENDED, CORE, READ_ONLY = 0x10, 0x20, 0x40
"""Flags in the type byte of a parameter."""

LOG_BLOCKS, LOG_OPERATIONS = 16, 128
"""So many log blocks there may be, and variables in all of them; the table of contents says so."""


class Entry(NamedTuple):
    """One variable as a client sees it."""

    variable: Variable
    type_byte: int
    """As it is sent, with flags where the table has them."""
    access: int
    """What the type byte does not tell, but the checksum covers."""

    @property
    def names(self) -> bytes:
        """Group and name, each with a zero behind it."""
        return self.variable.name.replace(".", "\0", 1).encode() + b"\0"


class TableOfContents:
    """The variables of one kind, numbered from 0."""

    def __init__(self, kind: str, entries: list[Entry], info_tail: bytes = b"") -> None:
        """Make all replies.

        Args:
            kind: What the table holds; tables of different kinds have different checksums, whatever is in them.
            entries: The variables, in the order of their numbers.
            info_tail: What follows count and checksum in the answer to "info".

        Raises:
            RangeError: If a name is too long for a packet.
        """
        for entry in entries:
            if len(entry.variable.name) - 1 > MAX_NAME:
                raise RangeError(
                    f"{kind} '{entry.variable.name}': {len(entry.variable.name) - 1} characters in group and name, "
                    f"at most {MAX_NAME} fit into a packet"
                )
        self.variables = tuple(entry.variable for entry in entries)
        self.numbers: Mapping[str, int] = {variable.name: number for number, variable in enumerate(self.variables)}
        """Number of each variable, by its complete name."""
        self.types = tuple(entry.type_byte for entry in entries)
        self.crc = _checksum(kind, entries)
        self.info = struct.pack("<BHL", INFO, len(entries), self.crc) + info_tail
        self._items = {
            struct.pack("<H", number): struct.pack("<BHB", ITEM, number, entry.type_byte) + entry.names
            for number, entry in enumerate(entries)
        }

    def __len__(self) -> int:
        return len(self.variables)

    def answer(self, payload: bytes) -> bytes | None:
        """Return the answer to a request on channel 0, None where the firmware gives none.

        The old commands with numbers of one byte are answered as by current firmware: the table looks empty.
        """
        command = payload[0] if payload else -1
        if command == ITEM:
            return self._items.get(payload[1:3], bytes((ITEM,)))
        if command == INFO:
            return self.info
        if command == INFO_V1:
            return bytes((INFO_V1, 0, 0, 0))
        return bytes((ITEM_V1,)) if command == ITEM_V1 else None


def _checksum(kind: str, entries: list[Entry]) -> int:
    # clients keep tables by their checksum alone, so that it covers everything, and the kind
    crc = zlib.crc32(kind.encode())
    for number, entry in enumerate(entries):
        crc = zlib.crc32(struct.pack("<HBB", number, entry.type_byte, entry.access) + entry.names, crc)
    return crc


def log_entry(variable: Variable) -> Entry:
    """Return a log variable as clients see it: its type byte is the bare type."""
    return Entry(variable, LOG_TYPES[variable.dtype.str[1:]], CORE if variable.is_core else 0)


def parameter_entry(variable: Variable) -> Entry:
    """Return a parameter as clients see it, with flags in its type byte."""
    byte = PARAMETER_TYPES[variable.dtype.str[1:]]
    byte |= (EXTENDED if variable.is_persistent else 0) | (CORE if variable.is_core else 0)
    return Entry(variable, byte | (READ_ONLY if variable.is_read_only else 0), 0)


@functools.cache
def log_toc(provider: int = 0) -> TableOfContents:
    """Return the table of all log variables of a drone with this provider."""
    limits = bytes((LOG_BLOCKS, LOG_OPERATIONS))
    return TableOfContents("log", [log_entry(variable) for variable in log_table(provider).values()], limits)


@functools.cache
def parameter_toc(provider: int = 0) -> TableOfContents:
    """Return the table of all parameters of a drone with this provider."""
    return TableOfContents("parameter", [parameter_entry(variable) for variable in parameter_table(provider).values()])
