"""The memory tester (0x15): tells a client whether bytes arrive as they were sent, both ways."""

from __future__ import annotations

from crazychoir_fw.crtp.memories.core_memory import CoreMemory
from crazychoir_fw.crtp.memories.memory import MemoryType


class TesterMemory(CoreMemory):
    """The byte at address a is a, and stays so.

    A packet that would write something else counts as one error in the log variable ``memTst.errCntW``, which the
    parameter ``memTst.resetW`` clears. Whether the firmware counts packets or bytes is not established.
    """

    type = MemoryType.TESTER

    def read(self, address: int, length: int) -> bytes | None:
        """Return low bytes of addresses."""
        return bytes((address + i) & 0xFF for i in range(length))

    def write(self, address: int, data: bytes) -> bool:
        """Have errors counted."""
        return data == self.read(address, len(data)) or super().write(address, data)
