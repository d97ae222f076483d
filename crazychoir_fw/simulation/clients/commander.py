"""Low-level setpoints of one drone."""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import ArrayLike

from crazychoir_fw._core import lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.onboard.core import check
from crazychoir_fw.simulation.clients.uplink import Uplink

_X_MODE = 0.707  # cflib's sine of 45 deg
_FULL_STATE = struct.Struct("<B9hI3h")  # type; position, velocity, acceleration; attitude; rates
_PORT_GENERIC = 7


class Commander:
    """Low-level setpoints, flown as long as they keep coming (500 ms, then the drone levels out)."""

    def __init__(self, name: str, uplink: Uplink) -> None:
        self._name = name
        self._uplink = uplink
        self._is_x_mode = False

    def _check(self, status: int, call: str) -> None:
        check(status, f"{self._name}: {call}")

    @property
    def is_client_xmode(self) -> bool:
        """Whether `send_setpoint` turns roll and pitch."""
        return self._is_x_mode

    def set_client_xmode(self, enabled: bool) -> None:
        """Turn roll and pitch of `send_setpoint` by 45 deg, for a frame whose forward is between two motors."""
        self._is_x_mode = enabled

    def send_setpoint(self, roll: float, pitch: float, yawrate: float, thrust: int) -> None:
        """Attitude (deg), yaw rate (deg/s, positive to the right) and thrust in [0, 65535].

        As in cflib, the first thrust after boot must be 0, which unlocks the motors, and positive pitch lowers the
        nose, so that the drone flies forward. The parameters ``flightmode.*`` give the numbers another meaning:
        rates in place of angles, velocities, a position, a climb rate in place of thrust.
        """
        if not 0 <= thrust <= 65535:
            raise RangeError(f"{self._name}: thrust {thrust} is outside [0, 65535]")
        if self._is_x_mode:
            roll, pitch = _X_MODE * (roll - pitch), _X_MODE * (roll + pitch)
        self._check(self._uplink.request("cf_send_rpyt", roll, -pitch, yawrate, int(thrust)), "send_setpoint")

    def send_stop_setpoint(self) -> None:
        """Stop the motors."""
        self._check(self._uplink.request("cf_send_stop"), "send_stop_setpoint")

    def send_velocity_world_setpoint(self, vx: float, vy: float, vz: float, yawrate: float) -> None:
        """Velocity (m/s, world) and yaw rate (deg/s, positive to the left)."""
        self._check(self._uplink.request("cf_send_velocity_world", vx, vy, vz, yawrate), "send_velocity_world_setpoint")

    def send_zdistance_setpoint(self, roll: float, pitch: float, yawrate: float, zdistance: float) -> None:
        """Attitude (deg), yaw rate (deg/s) and height (m)."""
        self._check(
            self._uplink.request("cf_send_zdistance", roll, pitch, yawrate, zdistance), "send_zdistance_setpoint"
        )

    def send_hover_setpoint(self, vx: float, vy: float, yawrate: float, zdistance: float) -> None:
        """Velocity (m/s, forward and left), yaw rate (deg/s) and height (m)."""
        self._check(self._uplink.request("cf_send_hover", vx, vy, yawrate, zdistance), "send_hover_setpoint")

    def send_position_setpoint(self, x: float, y: float, z: float, yaw: float) -> None:
        """Position (m, world) and yaw (deg)."""
        self._check(self._uplink.request("cf_send_position", x, y, z, yaw), "send_position_setpoint")

    def send_setpoint_manual(
        self, roll: float, pitch: float, yawrate: float, thrust_percentage: float, rate: bool
    ) -> None:
        """Roll and pitch as angles (deg) or rates (deg/s), yaw rate (deg/s), thrust (%).

        As in cflib, 0 to 100 % are 10001 to 60000 counts, and positive pitch lowers the nose.
        """
        if not 0 <= thrust_percentage <= 100:
            raise RangeError(f"{self._name}: thrust_percentage {thrust_percentage} is outside [0, 100]")
        thrust = int(10001 + 0.01 * thrust_percentage * 49999)
        self._check(self._uplink.request("cf_send_manual", roll, -pitch, yawrate, thrust, rate), "send_setpoint_manual")

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
        """Position (m), velocity (m/s), acceleration (m/s^2), attitude (quaternion xyzw) and body rates (rad/s).

        Sent as the radio carries it: lengths cut to millimeters, rates to milliradians, both within 32.7 of their
        unit, and the attitude, normalized, in 32 bits (0.2 deg).
        """
        call = "send_full_state_setpoint"
        moving = [*np.ravel(pos), *np.ravel(vel), *np.ravel(acc), rollrate, pitchrate, yawrate]
        quat = np.asarray(orientation, float)
        norm = np.linalg.norm(quat)
        if len(moving) != 12 or quat.shape != (4,) or not (np.isfinite(norm) and norm > 0.0):
            raise RangeError(f"{self._name}: {call}: allowed: three vectors of 3, a quaternion xyzw and three rates")
        numbers = [self._thousandths(value, call) for value in moving]
        attitude = lib.quatcompress(list(quat / norm))
        packet = _FULL_STATE.pack(lib.CF_GENERIC_FULL_STATE, *numbers[:9], attitude, *numbers[9:])
        self._uplink.request("packet", _PORT_GENERIC, 0, packet, call)

    def _thousandths(self, value: float, call: str) -> int:
        thousandths = value * 1000
        if not -32769 < thousandths < 32768:
            raise RangeError(f"{self._name}: {call}: {value} is outside [-32.768, 32.767]")
        return int(thousandths)

    def send_notify_setpoint_stop(self, remain_valid_milliseconds: int = 0) -> None:
        """Give way to the high-level commander; command it right after, or the motors stop."""
        del remain_valid_milliseconds  # the firmware ignores it as well
        self._uplink.request("cf_notify_setpoint_stop")
