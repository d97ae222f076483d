"""The EEPROM (0x00) and the configuration block in it: radio settings and trims of the accelerometer."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.crtp.memories.memory import CoreMemory, MemoryType
from crazychoir_fw.onboard.core import check

if TYPE_CHECKING:
    from crazychoir_fw.simulation.drone import Drone


class EepromMemory(CoreMemory):
    """What is written stays across reboots; a valid block counts from the next boot on."""

    type = MemoryType.EEPROM


@dataclass(frozen=True)
class Configuration:
    """What the configuration block holds."""

    channel: int = lib.CF_RADIO_CHANNEL
    """Radio channel, 0 to 125; the simulated radio has none, and it is only kept."""
    speed: int = lib.CF_RADIO_SPEED
    """0: 250 kbit/s, 1: 1 Mbit/s, 2: 2 Mbit/s; likewise."""
    address: int = lib.CF_RADIO_ADDRESS
    """40 bits; from the next boot on packed positions name the drone by the last byte, unless that is 0."""
    pitch_trim: float = 0.0
    """What the accelerometer shows while the drone is level (deg); taken off from the next boot on."""
    roll_trim: float = 0.0
    """Likewise."""

    @classmethod
    def of(cls, drone: Drone) -> Configuration | None:
        """Read the block of a drone; None when a client has damaged it."""
        block = ffi.new("cf_configuration_t *")
        if not lib.cf_configuration_unpack(drone.struct.configuration, block):
            return None
        return cls(block.channel, block.speed, block.address, block.pitch_trim, block.roll_trim)

    def write(self, drone: Drone) -> None:
        """Write the block of a drone.

        Raises:
            RangeError: If a value is outside its range.
        """
        trims_are_finite = math.isfinite(self.pitch_trim) and math.isfinite(self.roll_trim)
        if not (0 <= self.channel <= 125 and 0 <= self.speed <= 2 and 0 <= self.address < 1 << 40 and trims_are_finite):
            raise RangeError(
                f"{drone.id}: {self}; allowed: channel 0 to 125, speed 0 to 2, address of 40 bits, finite trims"
            )
        block = ffi.new("cf_configuration_t *")
        block.channel, block.speed, block.address = self.channel, self.speed, self.address
        block.pitch_trim, block.roll_trim = self.pitch_trim, self.roll_trim
        content = ffi.new("uint8_t[]", lib.CF_CONFIGURATION_BYTES)
        lib.cf_configuration_pack(content, block)
        data = bytes(content)
        status = drone.uplink.request("cf_write_memory", int(MemoryType.EEPROM), 0, len(data), data)
        check(status, f"{drone.id}: {self}")
