"""Memories whose bytes the core keeps: LED ring, lighthouse geometry, trajectories and the tester."""

from __future__ import annotations

import math
import struct

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.crtp.memories.memory import CoreMemory, MemoryType
from crazychoir_fw.crtp.service_context import ServiceContext


class LedRingMemory(CoreMemory):
    """Kept; `Drone.lights` shows the colors."""

    type = MemoryType.LED_RING


class LedTimingsMemory(CoreMemory):
    """Kept; `Drone.lights` lists the entries, they are not played."""

    type = MemoryType.LED_TIMINGS


CALIBRATION_START, STATION_PAGE = 0x1000, 0x100
GEOMETRY = struct.Struct("<12f?")
CALIBRATION = struct.Struct("<14fI?")


class LighthouseMemory(CoreMemory):
    """What is written counts at once, until the next boot; other base stations than the first two are refused."""

    type = MemoryType.LIGHTHOUSE

    def write(self, address: int, data: bytes) -> bool:
        """Take bytes that lie in one page and leave no number in it that is not finite."""
        start = address - address % STATION_PAGE
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
