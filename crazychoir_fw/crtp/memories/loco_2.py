"""The second memory of loco positioning (0x13): ids of the anchors, of those that are heard, and where they are."""

from __future__ import annotations

from crazychoir_fw.crtp.memories.loco import ANCHOR, ANCHORS, PAGE, anchor_page
from crazychoir_fw.crtp.memories.memory import MemoryType, ReadOnlyMemory, slice_of
from crazychoir_fw.crtp.service_context import ServiceContext

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
