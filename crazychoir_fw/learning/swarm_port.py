"""All drones of a world as arrays: what an environment reads of them, and how it commands them.

No call loops over drones in Python.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.learning.reading import Floats, Motion
from crazychoir_fw.onboard.core import check
from crazychoir_fw.simulation import World

_FARTHEST = 4.0  # [m], of the multi-ranger


def _place(path: str) -> int:
    """Return where a member of ``cf_t`` is (bytes)."""
    return int(ffi.offsetof("cf_t", *path.split(".")))


def _dtype_of(kind: Any) -> np.dtype[Any]:
    """Return a C structure of numbers as a structured type; of unions the first member."""
    plain = {"float": "f4", "double": "f8", "uint32_t": "u4", "int32_t": "i4", "_Bool": "?", "uint8_t": "u1"}
    if kind.kind == "enum":
        return np.dtype("i4")
    if kind.kind == "primitive":
        return np.dtype(plain[kind.cname])
    names, formats, offsets = [], [], []
    for name, field in kind.fields:
        if field.type.kind == "union" or name == "":
            continue
        names.append(name)
        formats.append(_dtype_of(field.type))
        offsets.append(field.offset)
    return np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": ffi.sizeof(kind)})


_READING = np.dtype(
    [
        *(("position", "f4", 3), ("velocity", "f4", 3), ("rotation", "f4", 9), ("rates", "f4", 3)),
        *(("specific_force", "f4", 3), ("battery_voltage", "f4"), ("is_out", "i4"), ("is_touching", "i4")),
    ]
)
assert _READING.itemsize == ffi.sizeof("cf_flight_reading_t")


class SwarmPort:
    """Views of the memory of all drones of a world, which must fly the built-in provider."""

    def __init__(self, world: World) -> None:
        if any(drone.provider_number != 0 for drone in world.drones):
            raise RangeError("learning: provider is a library, allowed: builtin; an app flies what was learned")
        self._world = world
        self._count = len(world.drones)
        self._memory = world.drones[0].memory  # keeps everything alive
        distances = {
            int(b.memory.ctypes.data - a.memory.ctypes.data)
            for a, b in zip(world.drones, world.drones[1:], strict=False)
        }
        self._stride = distances.pop() if distances else self._memory.nbytes
        if distances:
            raise RangeError("learning: other engine plugins stand between the drones of the scene")
        self.structs = ffi.new("cf_t *[]", [drone.struct for drone in world.drones])
        """The drones for C."""

        self._readings = np.zeros(self._count, _READING)
        self._for_c = ffi.cast("cf_flight_reading_t *", ffi.from_buffer(self._readings))
        self._const_structs = ffi.cast("const cf_t *const *", self.structs)
        has_deck = bool(world.drones[0].struct.config.vehicle.rangers.has_multiranger)
        self._ranges = self._rows(_place("onboard.decks.ranger.ranges"), np.uint16, lib.CF_RANGE_COUNT)
        self._ranges = self._ranges if has_deck else None

        self.qpos = self._motion(world.data.qpos, [drone.qpos_address for drone in world.drones], 7)
        """Poses: position (m, world) and quaternion (w, x, y, z), shape (N, 7)."""
        self.qvel = self._motion(world.data.qvel, [drone.qvel_address for drone in world.drones], 6)
        """Twists: velocity (m/s, world) and rates (rad/s, body), shape (N, 6)."""

        self.setpoints = np.zeros(self._count, _dtype_of(ffi.typeof("setpoint_t")))
        """What `send` sends, with the members of ``setpoint_t``."""
        self._numbers = np.arange(self._count, dtype=np.int32)
        self._status = ffi.new("cf_status_t *")
        self._chosen: NDArray[np.int32] | None = None

        held = _place("onboard.held_control")
        control = held + ffi.offsetof("cf_held_control_t", "control")
        self._is_held = self._view(held + ffi.offsetof("cf_held_control_t", "is_on"), np.bool_)
        self._control_mode = self._view(control + ffi.offsetof("control_t", "controlMode"), np.int32)
        self._forces = self._floats(control + ffi.offsetof("control_t", "normalizedForces"), 4)

    def _view(self, offset: int, dtype: Any) -> NDArray[Any]:
        cell = self._memory[offset : offset + np.dtype(dtype).itemsize].view(dtype)
        return as_strided(cell, shape=(self._count,), strides=(self._stride,))

    def _floats(self, offset: int, size: int) -> Floats:
        return self._rows(offset, np.float32, size)

    def _rows(self, offset: int, dtype: Any, size: int) -> NDArray[Any]:
        width = np.dtype(dtype).itemsize
        cells = self._memory[offset : offset + size * width].view(dtype)
        return as_strided(cells, shape=(self._count, size), strides=(self._stride, width))

    def _motion(self, values: NDArray[np.float64], addresses: list[int], size: int) -> NDArray[np.float64]:
        distances = set(np.diff(addresses).tolist()) or {size}
        if len(distances) != 1:
            raise RangeError("learning: bodies that move stand between the drones of the scene")
        first = values[addresses[0] : addresses[0] + size]
        return as_strided(first, shape=(self._count, size), strides=(8 * distances.pop(), 8))

    # ------------------------------------------------------------------------------------- reading

    def read(self, ticks: int) -> NDArray[Any]:
        """Read all drones after the tick that ended; the controllers see it in the next one.

        Args:
            ticks: How long a contact counts (ms).

        Returns:
            The members of ``cf_flight_reading_t`` as a structured array, shape (N,), valid until the next call.
        """
        lib.cf_read_flights(self._const_structs, self._count, ticks, self._for_c)
        return self._readings

    def estimate(self, ticks: int = 1) -> Motion:
        """Return what the drones believe after the tick that ended."""
        found = self.read(ticks)
        return Motion(*(found[name].copy() for name in ("position", "velocity", "rotation", "rates")))

    def truth(self) -> Motion:
        """Return where the drones are."""
        pose, twist = self.qpos.astype(np.float32), self.qvel.astype(np.float32)
        rotation = np.empty((self._count, 9), np.float32)
        quats = ffi.cast("const double *", self.qpos[0, 3:].ctypes.data)
        distance = self.qpos.strides[0] // self.qpos.itemsize
        lib.cf_rotations_of(quats, self._count, distance, ffi.cast("float *", rotation.ctypes.data))
        return Motion(pose[:, :3], twist[:, :3], rotation, twist[:, 3:])

    def ranges(self) -> Floats | None:
        """Return front, back, up, left, right of the multi-rangers (m, at most 4), shape (N, 5); None without decks."""
        if self._ranges is None:
            return None
        sides = (lib.CF_RANGE_FRONT, lib.CF_RANGE_BACK, lib.CF_RANGE_UP, lib.CF_RANGE_LEFT, lib.CF_RANGE_RIGHT)
        return np.minimum(self._ranges[:, sides].astype(np.float32) / np.float32(1000.0), np.float32(_FARTHEST))

    # ---------------------------------------------------------------------------------- commanding

    def send(self, **modes: int) -> None:
        """Send `setpoints` to all drones that have not failed, with these modes of their axes.

        Raises:
            RangeError: If a number in one is not finite.
        """
        mode = self.setpoints["mode"]
        for axis in ("x", "y", "z", "roll", "pitch", "yaw", "quat"):
            mode[axis] = modes.get(axis, 0)
        rows = self.setpoints if self._chosen is None else self.setpoints[self._chosen]
        numbers, count = ffi.from_buffer("int32_t[]", self._numbers), len(self._numbers)
        taken = lib.cf_send_setpoints(self.structs, numbers, count, ffi.from_buffer("uint8_t[]", rows), self._status)
        if taken < count:
            check(self._status[0], f"{self._world.drones[int(self._numbers[taken])].id}: setpoint")

    def command(self, numbers: NDArray[np.integer]) -> None:
        """Let `send` speak to these drones only, by their numbers: one that is out takes no setpoints."""
        self._numbers = np.ascontiguousarray(numbers, np.int32)
        self._chosen = None if len(numbers) == self._count else self._numbers

    def hold_motors(self, shares: Floats) -> None:
        """Hold shares of full thrust of M1 to M4, in [0, 1], shape (N, 4), in place of what controllers compute."""
        self._is_held[:] = True
        self._control_mode[:] = lib.controlModeForce
        self._forces[:] = shares
