"""The first memory of loco positioning (0x11): where eight anchors are."""

from __future__ import annotations

import struct

from crazychoir_fw._core import lib
from crazychoir_fw.crtp.memories.memory import MemoryType, ReadOnlyMemory
from crazychoir_fw.crtp.service_context import ServiceContext

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


def anchor_page(cf: object, number: int) -> bytes:
    """Return position (m, world) and validity of an anchor, as the driver on board knows it."""
    return ANCHOR.pack(*cf.onboard.decks.loco.anchors[number], True)
