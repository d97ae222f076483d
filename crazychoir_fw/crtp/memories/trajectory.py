"""The trajectory memory (0x12): pieces for the high-level commander, as raw bytes."""

from __future__ import annotations

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.crtp.memories.core_memory import CoreMemory
from crazychoir_fw.crtp.memories.memory import MemoryType
from crazychoir_fw.crtp.service_context import ServiceContext


class TrajectoryMemory(CoreMemory):
    """The same 4096 bytes that `HighLevelCommander.upload_trajectory` writes."""

    type = MemoryType.TRAJECTORY

    def __init__(self, context: ServiceContext) -> None:
        super().__init__(context)
        self.size = lib.CF_TRAJECTORY_MEMORY_BYTES

    def _present(self, address: int, length: int) -> bytes | None:
        data = ffi.new("uint8_t[]", length)
        status = lib.cf_read_trajectory(self._drone.struct, address, length, data)
        return bytes(data) if status == lib.CF_OK else None

    def _deliver(self, address: int, data: bytes) -> None:
        self._drone.uplink.request("cf_write_trajectory", address, len(data), data)
