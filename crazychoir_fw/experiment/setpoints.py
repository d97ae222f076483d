"""Commands of many drones as setpoints of the onboard software, all at once.

One setpoint is ``setpoint_t`` of the firmware (degrees, legacy pitch). `MotorCtrlFPQR` and its like make the same
bytes one by one; a swarm of 30 at 100 Hz has no time for that.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.errors import RangeError
from crazychoir_fw.messages import Twist

_FULL_THRUST = 65535.0


def _layout() -> np.dtype:
    """Return the fields of ``setpoint_t`` that commands use, where the compiler put them."""
    fields = {
        "timestamp": ("timestamp", np.uint32),
        "thrust": ("thrust", np.float32),
        **{f"rate_{axis}": (("attitudeRate", axis), np.float32) for axis in ("roll", "pitch", "yaw")},
        **{f"angle_{axis}": (("attitude", axis), np.float32) for axis in ("roll", "pitch", "yaw")},
        **{f"velocity_{axis}": (("velocity", axis), np.float32) for axis in "xyz"},
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


def setpoints(twist: Twist, kind: str, max_thrust: NDArray[np.float64], tick: int) -> list[bytes]:
    """Return the bytes of one setpoint per drone.

    Args:
        twist: Commands, arrays of shape (n, 3).
        kind: ``fpqr``, ``frpy`` or ``vel``.
        max_thrust: Thrust at full command (N), shape (n,).
        tick: When they are given (ms).

    Raises:
        RangeError: If a number is not finite; the message says which.
    """
    linear, angular = np.asarray(twist.linear, float), np.asarray(twist.angular, float)
    if not (np.isfinite(linear).all() and np.isfinite(angular).all()):
        bad = int(np.argmin(np.isfinite(linear).all(axis=-1) & np.isfinite(angular).all(axis=-1)))
        raise RangeError(f"command {bad} is linear {linear[bad]}, angular {angular[bad]}, allowed: finite numbers")
    block = np.zeros(len(linear), _LAYOUT)
    block["timestamp"] = tick % 2**32 or 1
    if kind == "vel":
        for k, axis in enumerate("xyz"):
            block[f"mode_{axis}"] = lib.modeVelocity
            block[f"velocity_{axis}"] = linear[:, k]
        block["mode_yaw"] = lib.modeVelocity
        block["rate_yaw"] = np.degrees(angular[:, 2])
    else:
        what, mode = ("rate", lib.modeVelocity) if kind == "fpqr" else ("angle", lib.modeAbs)
        degrees = np.degrees(angular if kind == "fpqr" else np.remainder(angular + np.pi, 2.0 * np.pi) - np.pi)
        block["thrust"] = np.clip(linear[:, 2] / max_thrust, 0.0, 1.0) * _FULL_THRUST
        for k, (axis, sign) in enumerate((("roll", 1.0), ("pitch", -1.0), ("yaw", 1.0))):
            block[f"mode_{axis}"] = mode
            block[f"{what}_{axis}"] = sign * degrees[:, k]  # positive pitch lifts the nose there
    raw, size = block.tobytes(), _LAYOUT.itemsize
    return [raw[k : k + size] for k in range(0, len(raw), size)]
