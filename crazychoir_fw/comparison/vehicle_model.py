"""One vehicle of our plant outside of a world: rotors driven by recorded motors, and the wrench at any motion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.comparison.signals import Array
from crazychoir_fw.onboard import vehicles
from crazychoir_fw.onboard.core import check

TICK = 0.001
_BEFORE = 1.5  # [s]: recordings that begin in the air have missed that much of a take-off


class VehicleModel:
    """Vehicle of platform cf2 with overrides, as in `DroneConfig.vehicle`."""

    def __init__(self, overrides: Mapping[str, Any]) -> None:
        """Build the vehicle.

        Raises:
            RangeError: If a value is outside its range.
            UnknownNameError: If there is no such parameter.
        """
        self.overrides = vehicles.overrides(dict(overrides))
        known = vehicles.parameters("cf2")
        everything: dict[str, Any] = {**{name: known[name].value for name in known}, **self.overrides}
        self.mass = float(everything["mass"])
        xx, yy, zz = everything["inertia"]
        xy, xz, yz = everything["products_of_inertia"]
        self.inertia: Array = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        self._config = ffi.new("cf_vehicle_config_t *")
        check(lib.cf_vehicle_default_config(self._config, lib.CF_PLATFORM_CF2), "vehicle")
        message = ffi.new(f"char[{lib.CF_PARAMETER_MESSAGE_BYTES}]")
        if lib.cf_parameters_set(self._config, vehicles.as_text(self.overrides).encode(), message) != lib.CF_OK:
            raise RangeError(ffi.string(message).decode(errors="replace"))
        self._vehicle = ffi.new("cf_vehicle_t *")
        check(lib.cf_vehicle_init(self._vehicle, self._config, 0, 0), "vehicle")

    def rotor_history(self, motors: Array, voltage: Array) -> RotorHistory:
        """Drive the rotors, one row per tick of 1 ms, after `_BEFORE` at the first row.

        Args:
            motors: Ratios, 0 to 65535, shape (T, 4).
            voltage: Of the pack (V), shape (T,).
        """
        rotors = ffi.addressof(self._vehicle, "rotors")
        ratios = np.ascontiguousarray(np.clip(np.rint(motors), 0, 65535), np.uint16)
        first = ffi.cast("uint16_t *", ratios.ctypes.data)
        volts = np.asarray(voltage, float).tolist()
        step = lib.cf_rotors_step
        for _ in range(round(_BEFORE / TICK)):
            step(rotors, first, volts[0])
        history = ffi.new("cf_rotors_t[]", len(ratios))
        for row in range(len(ratios)):
            step(rotors, first + 4 * row, volts[row])
            history[row] = rotors[0]
        return RotorHistory(self, history, len(ratios))


class RotorHistory:
    """State of the rotors at every tick; what they and the air do to the body at any of them."""

    def __init__(self, model: VehicleModel, rotors: Any, length: int) -> None:
        self.model, self._rotors, self.length = model, rotors, length

    def total_thrust(self) -> Array:
        """Return the sum of the four thrusts (N), shape (T,)."""
        return self.thrusts().sum(axis=1)

    def thrusts(self) -> Array:
        """Return the thrust of each rotor (N), shape (T, 4)."""
        rows = np.frombuffer(ffi.buffer(self._rotors), np.uint8).reshape(self.length, -1)
        begin = ffi.offsetof("cf_rotors_t", "thrust")
        return np.ascontiguousarray(rows[:, begin : begin + 16]).view(np.float32).astype(float)

    def wrench(self, ticks: NDArray[Any], rotation: Array, velocity: Array, rates: Array) -> tuple[Array, Array]:
        """Return forces (N, world) and torques (N m, body) at ticks and motions; one row each.

        Args:
            ticks: Numbers of ticks, shape (n,).
            rotation: Body to world, shape (n, 3, 3).
            velocity: World (m/s), shape (n, 3).
            rates: Body (rad/s), shape (n, 3).
        """
        count = len(ticks)
        vehicle = self.model._vehicle
        motion = [np.ascontiguousarray(part, np.float32) for part in (rotation.reshape(count, 9), velocity, rates)]
        result = np.zeros((2, count, 3), np.float32)
        r, v, w = (ffi.cast("float *", part.ctypes.data) for part in motion)
        force, torque = (ffi.cast("float *", part.ctypes.data) for part in result)
        for i in range(count):
            vehicle.rotors = self._rotors[min(max(int(ticks[i]), 0), self.length - 1)]
            lib.cf_vehicle_wrench(vehicle, r + 9 * i, v + 3 * i, w + 3 * i, force + 3 * i, torque + 3 * i)
        return result[0].astype(float), result[1].astype(float)
