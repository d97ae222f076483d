"""The show of the LED ring (0x17): colors by time."""

from __future__ import annotations

from crazychoir_fw.crtp.memories.core_memory import CoreMemory
from crazychoir_fw.crtp.memories.memory import MemoryType


class LedTimingsMemory(CoreMemory):
    """Kept; `Drone.lights` lists the entries, nobody plays them."""

    type = MemoryType.LED_TIMINGS
