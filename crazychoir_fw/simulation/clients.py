"""The client side of one drone, with cflib's vocabulary: commander, high-level commander, parameters, logs.

Scripts written for a real Crazyflie read the same here. Commands take effect at the next tick.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.core import check
from crazychoir_fw.errors import RangeError, StateError
from crazychoir_fw.variables import Variable, find

_PIECE_FLOATS = 33  # 8 coefficients of x, y, z and yaw, then the duration


class Commander:
    """Low-level setpoints, flown as long as they keep coming (500 ms, then the drone levels out)."""

    def __init__(self, name: str, cf: Any) -> None:
        self._name = name
        self._cf = cf

    def _check(self, status: int, call: str) -> None:
        check(status, f"{self._name}: {call}")

    def send_setpoint(self, roll: float, pitch: float, yawrate: float, thrust: int) -> None:
        """Attitude (deg), yaw rate (deg/s, positive to the right) and thrust in [0, 65535].

        As in cflib, the first thrust after boot must be 0, which unlocks the motors, and positive pitch lowers the
        nose, so that the drone flies forward.
        """
        if not 0 <= thrust <= 65535:
            raise RangeError(f"{self._name}: thrust {thrust} is outside [0, 65535]")
        self._check(lib.cf_send_rpyt(self._cf, roll, -pitch, yawrate, int(thrust)), "send_setpoint")

    def send_stop_setpoint(self) -> None:
        """Stop the motors."""
        self._check(lib.cf_send_stop(self._cf), "send_stop_setpoint")

    def send_velocity_world_setpoint(self, vx: float, vy: float, vz: float, yawrate: float) -> None:
        """Velocity (m/s, world) and yaw rate (deg/s, positive to the left)."""
        self._check(lib.cf_send_velocity_world(self._cf, vx, vy, vz, yawrate), "send_velocity_world_setpoint")

    def send_zdistance_setpoint(self, roll: float, pitch: float, yawrate: float, zdistance: float) -> None:
        """Attitude (deg), yaw rate (deg/s) and height (m)."""
        self._check(lib.cf_send_zdistance(self._cf, roll, pitch, yawrate, zdistance), "send_zdistance_setpoint")

    def send_hover_setpoint(self, vx: float, vy: float, yawrate: float, zdistance: float) -> None:
        """Velocity (m/s, forward and left), yaw rate (deg/s) and height (m)."""
        self._check(lib.cf_send_hover(self._cf, vx, vy, yawrate, zdistance), "send_hover_setpoint")

    def send_position_setpoint(self, x: float, y: float, z: float, yaw: float) -> None:
        """Position (m, world) and yaw (deg)."""
        self._check(lib.cf_send_position(self._cf, x, y, z, yaw), "send_position_setpoint")

    def send_setpoint_manual(
        self, roll: float, pitch: float, yawrate: float, thrust_percentage: float, rate: bool
    ) -> None:
        """Roll and pitch as angles (deg) or rates (deg/s), yaw rate (deg/s), thrust (%)."""
        if not 0 <= thrust_percentage <= 100:
            raise RangeError(f"{self._name}: thrust_percentage {thrust_percentage} is outside [0, 100]")
        thrust = int(thrust_percentage / 100 * 65535)
        self._check(lib.cf_send_manual(self._cf, roll, -pitch, yawrate, thrust, rate), "send_setpoint_manual")

    def send_full_state_setpoint(
        self,
        pos: ArrayLike,
        vel: ArrayLike,
        acc: ArrayLike,
        orientation: ArrayLike,
        rollrate: float,
        pitchrate: float,
        yawrate: float,
    ) -> None:
        """Position (m), velocity (m/s), acceleration (m/s^2), attitude (quaternion xyzw) and body rates (rad/s)."""
        x, v, a, q = (np.asarray(value, float) for value in (pos, vel, acc, orientation))
        full_state = {
            "position": {"x": x[0], "y": x[1], "z": x[2]},
            "velocity": {"x": v[0], "y": v[1], "z": v[2]},
            "acceleration": {"x": a[0], "y": a[1], "z": a[2]},
            "attitude": {"x": q[0], "y": q[1], "z": q[2], "w": q[3]},
            "body_rates": {"axis": [rollrate, pitchrate, yawrate]},
        }
        self._check(
            lib.cf_send_full_state(self._cf, ffi.new("cf_full_state_t *", full_state)), "send_full_state_setpoint"
        )

    def send_notify_setpoint_stop(self, remain_valid_milliseconds: int = 0) -> None:
        """Give way to the high-level commander; command it right after, or the motors stop."""
        del remain_valid_milliseconds  # the firmware ignores it as well
        lib.cf_notify_setpoint_stop(self._cf)


class HighLevelCommander:
    """Take-off, landing, go-to and uploaded trajectories, flown by the onboard planner."""

    def __init__(self, name: str, cf: Any) -> None:
        self._name = name
        self._cf = cf

    def _check(self, status: int, call: str) -> None:
        if status == lib.CF_ERR_STATE:
            reason = "a take-off needs a stopped planner" if call.startswith("takeoff") else "already landing"
            raise StateError(f"{self._name}: {call} is refused: {reason}")
        check(status, f"{self._name}: {call}")

    def takeoff(
        self, absolute_height_m: float, duration_s: float, group_mask: int = 0, yaw: float | None = 0.0
    ) -> None:
        """Rise straight up to a height (m, world), turning to yaw (rad; None keeps the present one)."""
        if not self._is_meant(group_mask):
            return
        status = lib.cf_takeoff(self._cf, absolute_height_m, duration_s, yaw or 0.0, yaw is None)
        self._check(status, f"takeoff(absolute_height_m={absolute_height_m}, duration_s={duration_s})")

    def land(self, absolute_height_m: float, duration_s: float, group_mask: int = 0, yaw: float | None = 0.0) -> None:
        """Sink straight down to a height (m, world); then the motors stop."""
        if not self._is_meant(group_mask):
            return
        status = lib.cf_land(self._cf, absolute_height_m, duration_s, yaw or 0.0, yaw is None)
        self._check(status, f"land(absolute_height_m={absolute_height_m}, duration_s={duration_s})")

    def stop(self, group_mask: int = 0) -> None:
        """Stop the motors at once."""
        if self._is_meant(group_mask):
            self._check(lib.cf_stop(self._cf), "stop()")

    def go_to(
        self,
        x: float,
        y: float,
        z: float,
        yaw: float,
        duration_s: float,
        relative: bool = False,
        linear: bool = False,
        group_mask: int = 0,
    ) -> None:
        """Fly to a position (m) and yaw (rad); relative ones count from the present setpoint."""
        if not self._is_meant(group_mask):
            return
        status = lib.cf_go_to(self._cf, x, y, z, yaw, duration_s, relative, linear)
        self._check(status, f"go_to({x}, {y}, {z}, yaw={yaw}, duration_s={duration_s})")

    def upload_trajectory(self, trajectory_id: int, pieces: ArrayLike, offset: int = 0) -> float:
        """Write polynomial pieces into trajectory memory and define them as one trajectory.

        Args:
            trajectory_id: 0 to 30.
            pieces: Shape (n, 33): for each piece 8 ascending coefficients of x, y, z (m) and yaw (rad), then the
                duration (s).
            offset: Place in the memory of 4096 bytes, a multiple of 4.

        Returns:
            Duration of the trajectory (s).
        """
        array = np.ascontiguousarray(pieces, dtype="<f4")
        if array.ndim != 2 or array.shape[1] != _PIECE_FLOATS or not np.all(np.isfinite(array)):
            raise RangeError(f"{self._name}: pieces have shape {array.shape}, allowed: (n, 33) finite numbers")
        data = array.tobytes()
        what = f"{self._name}: upload_trajectory({trajectory_id}, {len(array)} pieces, offset={offset})"
        if not 0 <= trajectory_id <= 255 or offset < 0:
            raise RangeError(f"{what}: allowed: trajectory 0 to 30, offset 0 to 4092")
        check(lib.cf_write_trajectory(self._cf, offset, len(data), data), what)
        self.define_trajectory(trajectory_id, offset, len(array))
        return float(array[:, -1].sum())

    def define_trajectory(self, trajectory_id: int, offset: int, n_pieces: int) -> None:
        """Name pieces that lie in trajectory memory at offset (bytes)."""
        status = lib.cf_define_trajectory(self._cf, trajectory_id, offset, n_pieces)
        check(status, f"{self._name}: define_trajectory({trajectory_id}, {offset}, {n_pieces})")

    def start_trajectory(
        self,
        trajectory_id: int,
        time_scale: float = 1.0,
        relative_position: bool = False,
        relative_yaw: bool = False,
        reversed: bool = False,
        group_mask: int = 0,
    ) -> None:
        """Follow an uploaded trajectory; a time scale above 1 slows it down."""
        if not self._is_meant(group_mask):
            return
        status = lib.cf_start_trajectory(self._cf, trajectory_id, time_scale, relative_position, relative_yaw, reversed)
        check(status, f"{self._name}: start_trajectory({trajectory_id}, time_scale={time_scale})")

    @property
    def is_trajectory_finished(self) -> bool:
        """Whether the current plan has come to its end."""
        return bool(lib.cf_is_trajectory_finished(self._cf))

    def _is_meant(self, group_mask: int) -> bool:
        commander = ffi.addressof(self._cf.onboard, "high_level")
        return bool(lib.cf_high_level_commander_is_in_group(commander, group_mask))


class _Variables(Mapping[str, float]):
    """Values of one drone by name; subclasses say what may be written."""

    _kind = "variable"

    def __init__(self, name: str, memory: NDArray[np.uint8], table: Mapping[str, Variable]) -> None:
        self._name = name
        self._memory = memory
        self._table = table

    def _cell(self, name: str) -> tuple[Variable, NDArray]:
        variable = find(self._table, name, self._kind, self._name)
        end = variable.offset + variable.dtype.itemsize
        return variable, self._memory[variable.offset : end].view(variable.dtype)

    def __getitem__(self, name: str) -> float | int:
        return self._cell(name)[1][0].item()

    def __iter__(self) -> Iterator[str]:
        return iter(self._table)

    def __len__(self) -> int:
        return len(self._table)

    def __repr__(self) -> str:
        return f"<{len(self)} {self._kind}s of {self._name}>"


class Log(_Variables):
    """Log variables: ``drone.log["stateEstimate.x"]``."""

    _kind = "log variable"


class Param(_Variables):
    """Parameters: ``drone.param["stabilizer.controller"] = 1``, or cflib's `set_value` and `get_value`."""

    _kind = "parameter"

    def __setitem__(self, name: str, value: float | int | str) -> None:
        variable, cell = self._cell(name)
        if variable.is_read_only:
            raise StateError(f"{self._name}: parameter {name} is read-only")
        cell[0] = self._converted(variable, value)

    def _converted(self, variable: Variable, value: float | int | str) -> float | int:
        try:
            number = float(value)
        except (TypeError, ValueError):
            number = float("nan")
        kind = variable.dtype
        if kind.kind == "f":
            if np.isfinite(number) and abs(number) <= float(np.finfo(kind).max):
                return number
            raise RangeError(f"{self._name}: {variable.name} is {value!r}, allowed: a finite number")
        limits = np.iinfo(kind)
        if not (number.is_integer() and limits.min <= number <= limits.max):
            raise RangeError(
                f"{self._name}: {variable.name} is {value!r}, allowed: a whole number {limits.min} to {limits.max}"
            )
        return int(number)

    def set_value(self, name: str, value: float | int | str) -> None:
        """Write a parameter; text is converted as cflib does."""
        self[name] = value

    def get_value(self, name: str) -> str:
        """Return a parameter as text, as cflib does."""
        return str(self[name])
