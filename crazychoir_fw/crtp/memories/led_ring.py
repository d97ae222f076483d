"""The driver of the LED ring (0x10): 12 colors."""

from __future__ import annotations

from crazychoir_fw.crtp.memories.core_memory import CoreMemory
from crazychoir_fw.crtp.memories.memory import MemoryType


class LedRingMemory(CoreMemory):
    """Kept; `Drone.lights` shows the colors."""

    type = MemoryType.LED_RING
