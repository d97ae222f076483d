"""The lighthouse memory (0x14): geometry and calibration of the base stations, as the estimator uses them."""

from __future__ import annotations

import math
import struct

from crazychoir_fw.crtp.memories.core_memory import CoreMemory
from crazychoir_fw.crtp.memories.memory import MemoryType

CALIBRATION_START, PAGE = 0x1000, 0x100
GEOMETRY = struct.Struct("<12f?")
CALIBRATION = struct.Struct("<14fI?")


class LighthouseMemory(CoreMemory):
    """What is written counts at once, until the next boot; other base stations than the first two are refused."""

    type = MemoryType.LIGHTHOUSE

    def write(self, address: int, data: bytes) -> bool:
        """Take bytes that lie in one page and leave no number in it that is not finite."""
        start = address - address % PAGE
        layout = GEOMETRY if start < CALIBRATION_START else CALIBRATION
        offset = address - start
        page = self.read(start, layout.size)
        if page is None or offset + len(data) > layout.size:
            return False
        values = layout.unpack(page[:offset] + data + page[offset + len(data) :])
        if not all(map(math.isfinite, values)):
            return False
        # as it will be read: truth values are 0 or 1
        return super().write(address, layout.pack(*values)[offset : offset + len(data)])
