"""A memory whose bytes the core has (`bindings/memories.h`)."""

from __future__ import annotations

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.crtp.memories.memory import NO_SERIAL, MemoryType
from crazychoir_fw.crtp.memories.pending_writes import PendingWrites
from crazychoir_fw.crtp.service_context import ServiceContext


class CoreMemory:
    """Read out of the drone, written into it by its uplink."""

    type: MemoryType
    serial = NO_SERIAL

    def __init__(self, context: ServiceContext) -> None:
        self.size: int = lib.cf_memory_bytes(self.type)
        self._drone = context.drone
        self._pending = PendingWrites(context, self._deliver)

    def read(self, address: int, length: int) -> bytes | None:
        """Return bytes as they are when everything that waits has been written."""
        return self._pending.read(self._present, address, length)

    def write(self, address: int, data: bytes) -> bool:
        """Have bytes written between two steps."""
        return self._pending.add(address, data)

    def _present(self, address: int, length: int) -> bytes | None:
        data = ffi.new("uint8_t[]", length)
        status = lib.cf_read_memory(self._drone.struct, self.type, address, length, data)
        return bytes(data) if status == lib.CF_OK else None

    def _deliver(self, address: int, data: bytes) -> None:
        self._drone.uplink.request("cf_write_memory", int(self.type), address, len(data), data)
