"""`RadioHandlerFPQR` and `RadioHandlerFRPY`: thrust with body rates, thrust with attitude."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

from crazychoir_fw.common.finite import finite, limited
from crazychoir_fw.radio.thrusting import ThrustDrone, ThrustHandler

_RATE, _ANGLE = 0, 1


class FPQRDrone(ThrustDrone):
    """Takes thrust and body rates."""

    # yaw too: another program may have left it at angles
    presets: ClassVar[Mapping[str, Any]] = {
        "flightmode.stabModeRoll": _RATE,
        "flightmode.stabModePitch": _RATE,
        "flightmode.stabModeYaw": _RATE,
    }
    max_rate: float
    """Largest rate about x and y (rad/s)."""
    max_yaw_rate: float
    """Largest rate about z (rad/s)."""

    def command(self, f: float, p: float, q: float, r: float) -> bool:
        """Give a command; it is repeated until the next one, or until the command time-out.

        Args:
            f: Thrust of all rotors (N), along body z.
            p: Body rate about x (rad/s), to the right.
            q: Body rate about y (rad/s), nose down.
            r: Body rate about z (rad/s), to the left.

        Returns:
            Whether it is taken; not before `takeoff`.

        Raises:
            RangeError: If one of them is no finite number.
        """
        f, p, q, r = finite(self._call("command"), f=f, p=p, q=q, r=r)
        thrust = self.thrust.raw(f)
        roll = math.degrees(limited(p, self.max_rate))
        pitch = math.degrees(limited(q, self.max_rate))  # cflib negates it: positive lifts the nose on board
        yaw = -math.degrees(limited(r, self.max_yaw_rate))  # the drone negates it: positive turns right in this packet
        return self._flight.give(lambda cf: cf.commander.send_setpoint(roll, pitch, yaw, thrust))


class RadioHandlerFPQR(ThrustHandler):
    """Flies drones by thrust (N) and body rates (rad/s); the twin of `MotorCtrlFPQR`.

    Limits: `max_rate` about x and y (720 deg/s) and `max_yaw_rate` about z (450 deg/s), both in rad/s; more is cut.
    """

    limits: ClassVar[Mapping[str, float]] = {"max_rate": math.radians(720.0), "max_yaw_rate": math.radians(450.0)}
    drone_class = FPQRDrone
    defaults: ClassVar[Mapping[str, Any]] = {"command_timeout_s": 0.2, "on_silence": "level"}


class FRPYDrone(ThrustDrone):
    """Takes thrust and attitude."""

    # roll and pitch too: another program may have left them at rates
    presets: ClassVar[Mapping[str, Any]] = {
        "flightmode.stabModeRoll": _ANGLE,
        "flightmode.stabModePitch": _ANGLE,
        "flightmode.stabModeYaw": _ANGLE,
    }
    max_tilt: float
    """Largest roll and pitch (rad)."""

    def command(self, f: float, roll: float, pitch: float, yaw: float) -> bool:
        """Give a command; it is repeated until the next one, or until the command time-out.

        Args:
            f: Thrust of all rotors (N), along body z.
            roll: Right-handed about x (rad): positive flies to the right.
            pitch: Right-handed about y (rad): positive lowers the nose and flies forward.
            yaw: Right-handed about z (rad): positive turns to the left.

        Returns:
            Whether it is taken; not before `takeoff`.

        Raises:
            RangeError: If one of them is no finite number.
        """
        f, roll, pitch, yaw = finite(self._call("command"), f=f, roll=roll, pitch=pitch, yaw=yaw)
        thrust = self.thrust.raw(f)
        roll = math.degrees(limited(math.remainder(roll, math.tau), self.max_tilt))
        # cflib negates it: positive lifts the nose on board
        pitch = math.degrees(limited(math.remainder(pitch, math.tau), self.max_tilt))
        yaw = math.degrees(math.remainder(yaw, math.tau))  # an angle, which the drone does not negate
        return self._flight.give(lambda cf: cf.commander.send_setpoint(roll, pitch, yaw, thrust))


class RadioHandlerFRPY(ThrustHandler):
    """Flies drones by thrust (N) and attitude (rad); the twin of `MotorCtrlFRPY`.

    Limit: `max_tilt`, largest roll and pitch (rad, 60 deg); more is cut.
    """

    limits: ClassVar[Mapping[str, float]] = {"max_tilt": math.radians(60.0)}
    drone_class = FRPYDrone
    defaults: ClassVar[Mapping[str, Any]] = {"command_timeout_s": 0.5, "on_silence": "level"}
