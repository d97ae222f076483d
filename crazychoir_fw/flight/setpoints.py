"""Commands of many drones as setpoints of the onboard software, all at once.

One setpoint is ``setpoint_t`` of the firmware (degrees, legacy pitch). `MotorCtrlFPQR` and its like make the same
bytes one by one; a swarm of 30 at 100 Hz has no time for that.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Twist
from crazychoir_fw.onboard.arrays import doubles

_KINDS = {"fpqr": lib.CF_TWIST_FPQR, "frpy": lib.CF_TWIST_FRPY, "vel": lib.CF_TWIST_VEL}
_BYTES = ffi.sizeof("setpoint_t")


def setpoints(twist: Twist, kind: str, max_thrust: NDArray[np.float64], tick: int) -> bytes:
    """Return one setpoint per drone, one behind the other.

    Args:
        twist: Commands, arrays of shape (n, 3).
        kind: ``fpqr``, ``frpy`` or ``vel``.
        max_thrust: Thrust at full command (N), shape (n,).
        tick: When they are given (ms).

    Raises:
        RangeError: If a number is not finite; the message says which.
    """
    linear, angular = twist.linear, twist.angular
    count = len(linear)
    made = bytearray(count * _BYTES)
    block = ffi.cast("setpoint_t *", ffi.from_buffer(made))
    numbers = doubles(linear, (count, 3)), doubles(angular, (count, 3)), doubles(max_thrust, (count,))
    good = lib.cf_make_setpoints(_KINDS[kind], count, *numbers, tick % 2**32 or 1, block)
    if good < count:
        raise RangeError(f"command {good} is linear {linear[good]}, angular {angular[good]}, allowed: finite numbers")
    return bytes(made)
