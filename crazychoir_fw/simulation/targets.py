"""Position set-point of each drone: the `ctrltarget` log variables, where these hold a position."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.simulation.drone import Drone

# x, y and z of a setpoint's place are three float32 in a row, their modes three numbers of four bytes
_PLACE = ffi.offsetof("cf_t", "onboard", "setpoint", "position", "x")
_MODES = ffi.offsetof("cf_t", "onboard", "setpoint", "mode", "x")


class Targets:
    """Reads the setpoints of a swarm through a view of the world's memory per drone: made once, read often."""

    def __init__(self, drones: Sequence[Drone]) -> None:
        self._places = [drone.memory[_PLACE : _PLACE + 12].view(np.float32) for drone in drones]
        self._modes = [drone.memory[_MODES : _MODES + 12].view(np.uint32) for drone in drones]

    def positions(self) -> NDArray[np.float64]:
        """Return the position set-point of each drone (m, world), shape (N, 3); NaN where there is none."""
        told = np.array(self._places, dtype=np.float64)
        told[(np.array(self._modes) != lib.modeAbs).any(axis=1)] = np.nan
        return told
