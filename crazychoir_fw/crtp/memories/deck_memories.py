"""Which expansion decks a drone carries, and the memories that come with them: deck info, 1-wire and loco."""

from __future__ import annotations

import struct
import zlib
from typing import TYPE_CHECKING, Any, NamedTuple

from crazychoir_fw._core import lib
from crazychoir_fw.crtp.memories.memory import MemoryType, ReadOnlyMemory, slice_of
from crazychoir_fw.crtp.service_context import ServiceContext

if TYPE_CHECKING:
    from crazychoir_fw.simulation.drone import Drone


class Deck(NamedTuple):
    """What a deck says of itself."""

    name: str
    """Name of the board, as in the parameters of group ``deck``."""
    product: int
    """Product id among those of the vendor 0xBC. General knowledge, not from docs/reference."""


LOCO = Deck("bcDWM1000", 0x06)
MULTIRANGER = Deck("bcMultiranger", 0x0C)
ZRANGER = Deck("bcZRanger2", 0x0E)
FLOW = Deck("bcFlow2", 0x0F)
LIGHTHOUSE = Deck("bcLighthouse4", 0x10)

_OF_POSITIONING = {
    lib.CF_POSITIONING_FLOW: FLOW,
    lib.CF_POSITIONING_LIGHTHOUSE: LIGHTHOUSE,
    lib.CF_POSITIONING_LOCO_TWR: LOCO,
    lib.CF_POSITIONING_LOCO_TDOA2: LOCO,
    lib.CF_POSITIONING_LOCO_TDOA3: LOCO,
}


def decks_of(drone: Drone) -> list[Deck]:
    """Return the decks of a drone: the one that positions it, then those that only measure ranges."""
    vehicle = drone.struct.config.vehicle
    positioning = _OF_POSITIONING.get(vehicle.positioning)
    found = [positioning] if positioning is not None else []
    if vehicle.rangers.has_multiranger:
        found.append(MULTIRANGER)
    if vehicle.rangers.has_zranger:
        found.append(ZRANGER)
    return found


_INFO_VERSION = 3
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
        self._info = bytes((_INFO_VERSION,)) + b"".join(records).ljust(_RECORDS * _RECORD.size, b"\0")

    def read(self, address: int, length: int) -> bytes | None:
        """Return bytes of the info section."""
        return slice_of(self._info, 0, address, length)


_WIRE_BYTES = 112
_WIRE_HEADER = struct.Struct("<BIBB")
_MARKER, _VENDOR, _NO_PINS = 0xEB, 0xBC, 0
_ELEMENTS_VERSION = 0
_BOARD_NAME, _BOARD_REVISION = 1, 2
_REVISION = "A"
_FAMILY = 0x0D  # first byte of a serial number; general knowledge, clients show it only


class OneWireMemory:
    """Reads never fail within its size, because a client that cannot read it never finishes to connect.

    What is written is kept as long as the drone is served, and does not matter to the drone.
    """

    type = MemoryType.ONE_WIRE
    size = _WIRE_BYTES

    def __init__(self, context: ServiceContext, deck: Deck) -> None:
        self.serial = struct.pack(">BBHI", _FAMILY, deck.product, 0, context.drone.struct.onboard.radio_id)
        self._content = bytearray(image(deck).ljust(_WIRE_BYTES, b"\xff"))

    def read(self, address: int, length: int) -> bytes | None:
        """Return bytes of the image."""
        return bytes(self._content[address : address + length])

    def write(self, address: int, data: bytes) -> bool:
        """Keep bytes."""
        self._content[address : address + len(data)] = data
        return True


def image(deck: Deck) -> bytes:
    """Return header and elements of a deck, each ended by its checksum."""
    header = _WIRE_HEADER.pack(_MARKER, _NO_PINS, _VENDOR, deck.product)
    texts = ((_BOARD_NAME, deck.name), (_BOARD_REVISION, _REVISION))
    elements = b"".join(bytes((key, len(text))) + text.encode() for key, text in texts)
    return _checked(header) + _checked(bytes((_ELEMENTS_VERSION, len(elements))) + elements)


def _checked(part: bytes) -> bytes:
    return part + bytes((zlib.crc32(part) & 0xFF,))


ANCHORS: int = lib.CF_LOCO_ANCHORS
ANCHOR = struct.Struct("<3f?")
PAGE = 0x100
_START = 0x1000


class LocoMemory(ReadOnlyMemory):
    """Read-only, and only as the client does it: the number of anchors, and one anchor after the other."""

    type = MemoryType.LOCO
    size = _START + ANCHORS * PAGE

    def __init__(self, context: ServiceContext) -> None:
        self._drone = context.drone

    def read(self, address: int, length: int) -> bytes | None:
        """Return the number of anchors, or one anchor."""
        if (address, length) == (0, 1):
            return bytes((ANCHORS,))
        number, offset = divmod(address - _START, PAGE)
        if number < 0 or offset != 0 or length != ANCHOR.size:
            return None
        return anchor_page(self._drone.struct, number)


def anchor_page(cf: Any, number: int) -> bytes:
    """Return position (m, world) and validity of an anchor, as the driver on board knows it."""
    return ANCHOR.pack(*cf.onboard.decks.loco.anchors[number], True)


_ACTIVE_START, _ANCHOR_START = 0x1000, 0x2000
_MAX_IDS = 16  # that a list has room for


class Loco2Memory(ReadOnlyMemory):
    """Read-only."""

    type = MemoryType.LOCO_2
    size = _ANCHOR_START + ANCHORS * PAGE

    def __init__(self, context: ServiceContext) -> None:
        self._drone = context.drone

    def read(self, address: int, length: int) -> bytes | None:
        """Return bytes of a list of ids or of one anchor."""
        if address < _ACTIVE_START:
            return slice_of(_id_list(range(ANCHORS)), 0, address, length)
        if address < _ANCHOR_START:
            heard = self._drone.struct.onboard.decks.loco.state  # within the last second
            active = [number for number in range(ANCHORS) if heard >> number & 1]
            return slice_of(_id_list(active), _ACTIVE_START, address, length)
        number, offset = divmod(address - _ANCHOR_START, PAGE)
        if offset + length > ANCHOR.size:
            return None
        return slice_of(anchor_page(self._drone.struct, number), 0, offset, length)


def _id_list(ids: range | list[int]) -> bytes:
    return bytes((len(ids), *ids)).ljust(1 + _MAX_IDS, b"\0")
