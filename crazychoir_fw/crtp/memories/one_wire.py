"""The memory on a deck (0x01), from which a client learns at connect which decks there are."""

from __future__ import annotations

import struct
import zlib

from crazychoir_fw.crtp.memories.decks import Deck
from crazychoir_fw.crtp.memories.memory import MemoryType
from crazychoir_fw.crtp.service_context import ServiceContext

_BYTES = 112
_HEADER = struct.Struct("<BIBB")
_MARKER, _VENDOR, _NO_PINS = 0xEB, 0xBC, 0
_VERSION = 0
_BOARD_NAME, _BOARD_REVISION = 1, 2
_REVISION = "A"
_FAMILY = 0x0D  # first byte of a serial number; general knowledge, clients show it only


class OneWireMemory:
    """Reads never fail within its size, because a client that cannot read it never finishes to connect.

    What is written is kept as long as the drone is served, and does not matter to the drone.
    """

    type = MemoryType.ONE_WIRE
    size = _BYTES

    def __init__(self, context: ServiceContext, deck: Deck) -> None:
        self.serial = struct.pack(">BBHI", _FAMILY, deck.product, 0, context.drone.struct.onboard.radio_id)
        self._content = bytearray(image(deck).ljust(_BYTES, b"\xff"))

    def read(self, address: int, length: int) -> bytes | None:
        """Return bytes of the image."""
        return bytes(self._content[address : address + length])

    def write(self, address: int, data: bytes) -> bool:
        """Keep bytes."""
        self._content[address : address + len(data)] = data
        return True


def image(deck: Deck) -> bytes:
    """Return header and elements of a deck, each ended by its checksum."""
    header = _HEADER.pack(_MARKER, _NO_PINS, _VENDOR, deck.product)
    texts = ((_BOARD_NAME, deck.name), (_BOARD_REVISION, _REVISION))
    elements = b"".join(bytes((key, len(text))) + text.encode() for key, text in texts)
    return _checked(header) + _checked(bytes((_VERSION, len(elements))) + elements)


def _checked(part: bytes) -> bytes:
    return part + bytes((zlib.crc32(part) & 0xFF,))
