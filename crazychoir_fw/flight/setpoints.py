"""Commands of many drones as setpoints of the onboard software, all at once.

One setpoint is ``setpoint_t`` of the firmware (degrees, legacy pitch). `MotorCtrlFPQR` and its like make the same
bytes one by one; a swarm of 30 at 100 Hz has no time for that.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.finite import are_finite
from crazychoir_fw.common.messages import Twist

_FULL_THRUST = 65535.0


def _layout() -> np.dtype:
    """Return the fields of ``setpoint_t`` that commands use, where the compiler put them."""
    three = (np.float32, 3)  # of one type each, and so side by side
    fields = {
        "timestamp": ("timestamp", np.uint32),
        "thrust": ("thrust", np.float32),
        "rates": (("attitudeRate", "roll"), three),
        "angles": (("attitude", "roll"), three),
        "velocity": (("velocity", "x"), three),
        **{f"mode_{axis}": (("mode", axis), np.int32) for axis in ("x", "y", "z", "roll", "pitch", "yaw")},
    }
    offsets = []
    for path, _ in fields.values():
        path = (path,) if isinstance(path, str) else path
        offsets.append(ffi.offsetof("setpoint_t", *path))
    kinds = [kind for _, kind in fields.values()]
    size = ffi.sizeof("setpoint_t")
    return np.dtype({"names": list(fields), "formats": kinds, "offsets": offsets, "itemsize": size})


_LAYOUT = _layout()


def _modes(kind: str) -> bytes:
    """Return a setpoint with the modes of a kind of command, and nothing else."""
    empty = np.zeros(1, _LAYOUT)
    for axis in ("x", "y", "z") if kind == "vel" else ():
        empty[f"mode_{axis}"] = lib.modeVelocity
    for axis in ("yaw",) if kind == "vel" else ("roll", "pitch", "yaw"):
        empty[f"mode_{axis}"] = lib.modeAbs if kind == "frpy" else lib.modeVelocity
    return empty.tobytes()


_EMPTY = {kind: _modes(kind) for kind in ("fpqr", "frpy", "vel")}
_PER_RADIAN = np.degrees(1.0) * np.array([1.0, -1.0, 1.0])  # positive pitch lifts the nose on board


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
    linear, angular = np.asarray(twist.linear, float), np.asarray(twist.angular, float)
    if not are_finite(linear, angular):
        bad = int(np.argmin(np.isfinite(linear).all(axis=-1) & np.isfinite(angular).all(axis=-1)))
        raise RangeError(f"command {bad} is linear {linear[bad]}, angular {angular[bad]}, allowed: finite numbers")
    filled = bytearray(_EMPTY[kind] * len(linear))
    block = np.frombuffer(filled, _LAYOUT)
    block["timestamp"] = tick % 2**32 or 1
    if kind == "vel":
        block["velocity"] = linear
        block["rates"][:, 2] = np.degrees(angular[:, 2])
    else:
        if kind == "fpqr":
            block["rates"] = angular * _PER_RADIAN
        else:
            block["angles"] = (np.remainder(angular + np.pi, 2.0 * np.pi) - np.pi) * _PER_RADIAN
        block["thrust"] = np.minimum(np.maximum(linear[:, 2] / max_thrust, 0.0), 1.0) * _FULL_THRUST
    return bytes(filled)
