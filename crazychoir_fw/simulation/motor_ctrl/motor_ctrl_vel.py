"""`MotorCtrlVel`: velocity in the world."""

from __future__ import annotations

import math
from collections.abc import Sequence

from crazychoir_fw._core import lib
from crazychoir_fw.common.finite import finite, three
from crazychoir_fw.simulation.motor_ctrl.motor_ctrl import MotorCtrl


class MotorCtrlVel(MotorCtrl):
    """Takes a velocity (m/s, world) and a yaw rate (rad/s), and lets the onboard velocity loops fly them."""

    controllers = ("pid",)
    others = "indi does not follow yaw rates; mellinger, lee and brescianini do not follow velocities"

    def command(self, vx: float, vy: float, vz: float, yaw_rate: float = 0.0) -> None:
        """Give a command; it is repeated until the next one, also when it is to stand still.

        Args:
            vx: Velocity along x (m/s, world).
            vy: Velocity along y (m/s, world).
            vz: Velocity along z (m/s, world).
            yaw_rate: Turn (rad/s), positive to the left.

        Raises:
            RangeError: If one of them is no finite number.
        """
        vx, vy, vz, yaw_rate = finite(self._who("command"), vx=vx, vy=vy, vz=vz, yaw_rate=yaw_rate)
        setpoint = self.new_setpoint()
        mode, velocity = setpoint.mode, setpoint.velocity
        mode.x = mode.y = mode.z = mode.yaw = lib.modeVelocity
        velocity.x, velocity.y, velocity.z = vx, vy, vz
        setpoint.attitudeRate.yaw = math.degrees(yaw_rate)
        self.send(setpoint)

    def cmd_vel(self, linear: Sequence[float], angular: Sequence[float]) -> None:
        """The same as a Twist: velocity (m/s, world) in linear, yaw rate (rad/s) in angular z."""
        who = self._who("cmd_vel")
        _, _, yaw_rate = three(who, "angular", angular)
        self.command(*three(who, "linear", linear), yaw_rate)  # type: ignore[arg-type]
