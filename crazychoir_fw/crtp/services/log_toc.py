"""What can be logged, as the log service tells it (crtp-cflib dossier section 8.1)."""

from __future__ import annotations

import functools
import struct
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from crazychoir_fw._core import lib
from crazychoir_fw.crtp.packet import MAX_PAYLOAD
from crazychoir_fw.crtp.toc import toc_crc
from crazychoir_fw.simulation.clients.variables import is_computed_when_read
from crazychoir_fw.variables import Variable, log_table

GET_ITEM, GET_INFO = 2, 3
"""Commands of protocol versions from 4 on."""

MAX_BLOCKS = 16
MAX_VALUES = 128
"""Values in all blocks of a drone together."""

_TYPES = {
    np.dtype(np.uint8): lib.CF_LOG_UINT8,
    np.dtype(np.uint16): lib.CF_LOG_UINT16,
    np.dtype(np.uint32): lib.CF_LOG_UINT32,
    np.dtype(np.int8): lib.CF_LOG_INT8,
    np.dtype(np.int16): lib.CF_LOG_INT16,
    np.dtype(np.int32): lib.CF_LOG_INT32,
    np.dtype(np.float32): lib.CF_LOG_FLOAT,
}


class LogVariable(NamedTuple):
    """Where a variable is, and what must be done to read it."""

    offset: int
    """Place within ``cf_t`` (bytes)."""
    stored: int
    """Type, as the log service numbers them."""
    is_computed_when_read: bool
    """Whether the log variables are brought up to date first."""


@dataclass(frozen=True)
class LogToc:
    """The table of one provider with all replies ready."""

    variables: tuple[LogVariable, ...]
    """By id."""
    info: bytes
    """Answers `GET_INFO`."""
    items: tuple[bytes, ...]
    """By id; they answer `GET_ITEM`."""
    no_item: bytes = bytes((GET_ITEM,))
    """Answers `GET_ITEM` for an id that there is not."""


@functools.cache
def log_toc(provider: int) -> LogToc:
    """Return the table of contents of drones with this provider.

    Variables whose names do not fit a packet are left out; firmware with such names does not boot.
    """
    rows = [row for row in log_table(provider).values() if len(_names(row)) <= MAX_PAYLOAD - 4]
    info = struct.pack("<BHIBB", GET_INFO, len(rows), toc_crc(rows, "log"), MAX_BLOCKS, MAX_VALUES)
    return LogToc(
        variables=tuple(
            LogVariable(row.offset, _TYPES[row.dtype], is_computed_when_read(row, provider)) for row in rows
        ),
        info=info,
        items=tuple(
            struct.pack("<BHB", GET_ITEM, index, _TYPES[row.dtype]) + _names(row) for index, row in enumerate(rows)
        ),
    )


def _names(row: Variable) -> bytes:
    group, _, name = row.name.partition(".")
    return b"%s\0%s\0" % (group.encode("latin-1", "replace"), name.encode("latin-1", "replace"))
