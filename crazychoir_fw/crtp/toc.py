"""Tables of contents: what log and parameter service have in common (crtp-cflib dossier sections 8.1, 8.4 and 9)."""

from __future__ import annotations

import zlib
from collections.abc import Iterable

from crazychoir_fw.variables import Variable


def toc_crc(rows: Iterable[Variable], kind: str) -> int:
    """Return the number by which clients recognize a table that they have stored.

    It changes with everything that they store: order, names, types and access. Clients keep logs and parameters in one
    folder, by this number alone, so it also says of which kind the table is.

    Args:
        rows: The variables in the order of their ids.
        kind: ``log`` or ``param``.
    """
    crc = zlib.crc32(kind.encode())
    for index, row in enumerate(rows):
        access = f"{row.is_core:d}{row.is_persistent:d}{row.is_read_only:d}"
        crc = zlib.crc32(f"{index} {row.name} {row.dtype.str} {access}\n".encode(), crc)
    return crc
