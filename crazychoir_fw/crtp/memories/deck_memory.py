"""The memory of decks with firmware of their own (0x19): which there are, and that nothing can be flashed."""

from __future__ import annotations

import struct

from crazychoir_fw.crtp.memories.decks import LIGHTHOUSE, decks_of
from crazychoir_fw.crtp.memories.memory import MemoryType, ReadOnlyMemory, slice_of
from crazychoir_fw.crtp.service_context import ServiceContext

_VERSION = 3
_RECORDS = 8  # two for each of up to four decks
_RECORD = struct.Struct("<BBIII18s")  # two bytes of bits, hash and length of the firmware, base address, name
_COMMANDS, _COMMAND_BYTES = 0x1000, 0x20
_IS_VALID, _IS_STARTED = 1, 2
_DECK_BYTES = 0x10000000


class DeckMemory(ReadOnlyMemory):
    """Lists the lighthouse deck, whose firmware runs; it cannot be read, written or upgraded."""

    type = MemoryType.DECK
    size = _COMMANDS + _RECORDS * _COMMAND_BYTES

    def __init__(self, context: ServiceContext) -> None:
        records = [
            _RECORD.pack(_IS_VALID | _IS_STARTED, 0, 0, 0, (number + 1) * _DECK_BYTES, deck.name.encode())
            for number, deck in enumerate(decks_of(context.drone))
            if deck == LIGHTHOUSE
        ]
        self._info = bytes((_VERSION,)) + b"".join(records).ljust(_RECORDS * _RECORD.size, b"\0")

    def read(self, address: int, length: int) -> bytes | None:
        """Return bytes of the info section."""
        return slice_of(self._info, 0, address, length)
