"""`MotorCtrlFRPY`: thrust and attitude."""

from __future__ import annotations

import math
from collections.abc import Sequence

from crazychoir_fw._core import lib
from crazychoir_fw.common.finite import finite, three
from crazychoir_fw.onboard.thrust import thrust_counts
from crazychoir_fw.simulation.motor_ctrl.motor_ctrl import MotorCtrl


class MotorCtrlFRPY(MotorCtrl):
    """Takes thrust (N) and roll, pitch, yaw (rad), and lets the onboard attitude loops fly them."""

    controllers = ("pid", "mellinger", "lee", "indi")

    def command(self, f: float, roll: float, pitch: float, yaw: float) -> None:
        """Give a command; it is repeated until the next one.

        Args:
            f: Thrust of all rotors (N), along body z. Motors saturate at 0 and `max_thrust`.
            roll: Right-handed about x (rad): positive flies to the right.
            pitch: Right-handed about y (rad): positive lowers the nose and flies forward.
            yaw: Right-handed about z (rad): positive turns to the left.

        Raises:
            RangeError: If one of them is no finite number.
        """
        f, roll, pitch, yaw = finite(self._who("command"), f=f, roll=roll, pitch=pitch, yaw=yaw)
        setpoint = self.new_setpoint()
        setpoint.thrust = thrust_counts(f, self.max_thrust)
        mode, attitude = setpoint.mode, setpoint.attitude
        mode.roll = mode.pitch = mode.yaw = lib.modeAbs
        attitude.roll = math.degrees(math.remainder(roll, math.tau))
        attitude.pitch = -math.degrees(math.remainder(pitch, math.tau))  # positive lifts the nose there
        attitude.yaw = math.degrees(math.remainder(yaw, math.tau))
        self.send(setpoint)

    def cmd_vel(self, linear: Sequence[float], angular: Sequence[float]) -> None:
        """The same as a Twist: thrust (N) in linear z, roll, pitch, yaw (rad) in angular."""
        who = self._who("cmd_vel")
        _, _, f = three(who, "linear", linear)
        self.command(f, *three(who, "angular", angular))  # type: ignore[arg-type]
