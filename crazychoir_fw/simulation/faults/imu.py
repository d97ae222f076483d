"""An inertial sensor that is stuck, off, or noisy."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.onboard.core import check
from crazychoir_fw.simulation.faults.fault import Fault
from crazychoir_fw.simulation.faults.rules import Number, Switch, Word, ruled

if TYPE_CHECKING:
    from crazychoir_fw.simulation.drone import Drone
    from crazychoir_fw.simulation.world import World

_RAD_PER_DEG = math.pi / 180.0
_M_PER_S2_PER_G = 9.81
_SENSORS = {"gyro": (0, _RAD_PER_DEG), "acc": (3, _M_PER_S2_PER_G)}  # first bit of its axes, SI units in its own


@dataclass(frozen=True, kw_only=True)
class ImuFault(Fault):
    """Readings of the gyroscope or the accelerometer go wrong, on one axis or on all.

    A second fault on the same axes replaces the first one.
    """

    kind: ClassVar[str] = "imu"

    sensor: str = ruled(Word(("gyro", "acc")), "gyro")
    """``gyro`` or ``acc``."""

    axis: str = ruled(Word(("x", "y", "z", "all")), "all")
    """``x``, ``y``, ``z`` or ``all``."""

    stuck: bool = ruled(Switch(), False)
    """The first reading of the fault is given again and again."""

    bias: float = ruled(Number(-4000.0, 4000.0, "deg/s or g"), 0.0)
    """Added to the readings (deg/s, or g)."""

    noise: float = ruled(Number(0.0, 4000.0, "deg/s or g"), 0.0)
    """Standard deviation of white noise that is added to each reading, 1000 times a second (deg/s, or g)."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (self.stuck or self.bias or self.noise):
            raise RangeError("imu: nothing is wrong with it; allowed: stuck, bias or noise")
        if self.stuck and (self.bias or self.noise):
            raise RangeError("imu: a stuck sensor shows neither bias nor noise")

    def begin(self, world: World, drone: Drone, seed: int) -> None:
        """Spoil the readings."""
        self._inject(drone, self.stuck, self.bias, self.noise, seed)

    def end(self, world: World, drone: Drone) -> None:
        """Show the true readings again."""
        self._inject(drone, False, 0.0, 0.0, 0)

    def _inject(self, drone: Drone, stuck: bool, bias: float, noise: float, seed: int) -> None:
        first, unit = _SENSORS[self.sensor]
        axes = 7 if self.axis == "all" else 1 << "xyz".index(self.axis)
        fault = [[axes << first, stuck, bias * unit, noise * unit]]
        check(drone.uplink.dispatch("cf_inject_imu", fault, seed), f"{drone.id}: imu fault")
