"""All drones of a world as arrays: what an environment reads of them, and how it commands them, in calls that do not
grow with their number in Python.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.learning.reading import Floats, Motion, rotation_of
from crazychoir_fw.onboard.core import check
from crazychoir_fw.simulation import World

_RADIANS = np.float32(np.pi / 180.0)
_GRAVITY = np.float32(9.81)  # [m/s^2] in a g, as on board
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

        estimate = _place("onboard.estimator.estimate")
        self._position = self._floats(estimate + ffi.offsetof("state_t", "position") + 4, 3)
        self._velocity = self._floats(estimate + ffi.offsetof("state_t", "velocity") + 4, 3)
        self._quat_xyzw = self._floats(estimate + ffi.offsetof("state_t", "attitudeQuaternion"), 4)
        data = _place("onboard.sensors.data")
        self._gyro = self._floats(data + ffi.offsetof("sensorData_t", "gyro"), 3)
        self._acc = self._floats(data + ffi.offsetof("sensorData_t", "acc"), 3)
        self._voltage = self._view(_place("vehicle.battery.voltage"), np.float32)
        self._fault = self._view(_place("onboard.fault"), np.int32)
        self._state = self._view(_place("onboard.supervisor.state"), np.int32)
        self._tick = self._view(_place("onboard.tick"), np.uint32)
        self._contact_tick = self._view(_place("contacts.tick"), np.uint32)
        self._contact_count = self._view(_place("contacts.count"), np.uint8)
        self._ranges = self._floats_of("onboard.decks.ranger.ranges", np.uint16, lib.CF_RANGE_COUNT)

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

    def _floats_of(self, path: str, dtype: Any, size: int) -> NDArray[Any] | None:
        has_deck = bool(self._world.drones[0].struct.config.vehicle.rangers.has_multiranger)
        return self._rows(_place(path), dtype, size) if has_deck else None

    def _motion(self, values: NDArray[np.float64], addresses: list[int], size: int) -> NDArray[np.float64]:
        distances = set(np.diff(addresses).tolist()) or {size}
        if len(distances) != 1:
            raise RangeError("learning: bodies that move stand between the drones of the scene")
        first = values[addresses[0] : addresses[0] + size]
        return as_strided(first, shape=(self._count, size), strides=(8 * distances.pop(), 8))

    # ------------------------------------------------------------------------------------- reading

    def estimate(self) -> Motion:
        """Return what the drones believe after the tick that ended: the controllers see it in the next one."""
        quat_wxyz = self._quat_xyzw[:, (3, 0, 1, 2)]
        return Motion(
            self._position.copy(), self._velocity.copy(), rotation_of(quat_wxyz), self._gyro * _RADIANS
        )

    def truth(self) -> Motion:
        """Return where the drones are."""
        pose, twist = self.qpos.astype(np.float32), self.qvel.astype(np.float32)
        return Motion(pose[:, :3], twist[:, :3], rotation_of(pose[:, 3:]), twist[:, 3:])

    def specific_force(self) -> Floats:
        """Return what the accelerometers measured last (m/s^2, body), shape (N, 3)."""
        return self._acc * _GRAVITY

    def ranges(self) -> Floats | None:
        """Return front, back, up, left, right of the multi-rangers (m, at most 4), shape (N, 5); None without decks."""
        if self._ranges is None:
            return None
        sides = (lib.CF_RANGE_FRONT, lib.CF_RANGE_BACK, lib.CF_RANGE_UP, lib.CF_RANGE_LEFT, lib.CF_RANGE_RIGHT)
        return np.minimum(self._ranges[:, sides].astype(np.float32) / np.float32(1000.0), np.float32(_FARTHEST))

    def battery_voltage(self) -> Floats:
        """Return voltages (V), shape (N,)."""
        return self._voltage.copy()

    def is_out(self) -> NDArray[np.bool_]:
        """Return which drones the core or the supervisor has stopped, shape (N,)."""
        is_stopped = (self._state == lib.supervisorStateCrashed) | (self._state == lib.supervisorStateLocked)
        return is_stopped | (self._fault != 0)

    def is_touching(self, ticks: int) -> NDArray[np.bool_]:
        """Return which drones touched anything in the latest so many ticks, shape (N,)."""
        return (self._contact_count > 0) & (self._tick - self._contact_tick < ticks)

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
        taken = lib.cf_send_setpoints(
            self.structs, numbers, count, ffi.from_buffer("uint8_t[]", rows), self._status
        )
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
