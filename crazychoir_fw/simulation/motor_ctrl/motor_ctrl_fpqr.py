"""`MotorCtrlFPQR`: thrust and body rates."""

from __future__ import annotations

import math
from collections.abc import Sequence

from crazychoir_fw._core import lib
from crazychoir_fw.common.finite import finite, three
from crazychoir_fw.onboard.thrust import thrust_counts
from crazychoir_fw.simulation.motor_ctrl.motor_ctrl import MotorCtrl


class MotorCtrlFPQR(MotorCtrl):
    """Takes thrust (N) and body rates p, q, r (rad/s: forward, left, up), and lets the onboard rate loops fly them."""

    controllers = ("pid",)
    others = "indi does not follow yaw rates; mellinger, lee and brescianini do not follow roll and pitch rates"

    def command(self, f: float, p: float, q: float, r: float) -> None:
        """Give a command; it is repeated until the next one.

        Args:
            f: Thrust of all rotors (N), along body z. Motors saturate at 0 and `max_thrust`; below 4 times the least
                thrust of a motor they stand still.
            p: Body rate about x (rad/s), to the right.
            q: Body rate about y (rad/s), nose down.
            r: Body rate about z (rad/s), to the left.

        Raises:
            RangeError: If one of them is no finite number.
        """
        f, p, q, r = finite(self._who("command"), f=f, p=p, q=q, r=r)
        setpoint = self.new_setpoint()
        setpoint.thrust = thrust_counts(f, self.max_thrust)
        mode, rate = setpoint.mode, setpoint.attitudeRate
        mode.roll = mode.pitch = mode.yaw = lib.modeVelocity
        rate.roll = math.degrees(p)
        rate.pitch = -math.degrees(q)  # positive lifts the nose there
        rate.yaw = math.degrees(r)
        self.send(setpoint)

    def cmd_vel(self, linear: Sequence[float], angular: Sequence[float]) -> None:
        """The same as a Twist: thrust (N) in linear z, body rates (rad/s) in angular."""
        who = self._who("cmd_vel")
        _, _, f = three(who, "linear", linear)
        self.command(f, *three(who, "angular", angular))  # type: ignore[arg-type]
