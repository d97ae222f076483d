"""`MotorCtrlXYZ`: go-to by the onboard planner."""

from __future__ import annotations

from collections.abc import Sequence

from crazychoir_fw._core import lib
from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.common.finite import finite, three
from crazychoir_fw.onboard.core import check
from crazychoir_fw.simulation.motor_ctrl.motor_ctrl import MotorCtrl
from crazychoir_fw.simulation.supervisor_resets import is_about_to_reset


class MotorCtrlXYZ(MotorCtrl):
    """Takes a point and a duration, and lets the onboard planner fly there and stay.

    A new command in flight plans on from the present reference, with its velocity and acceleration.
    """

    def command(self, x: float, y: float, z: float, duration: float, yaw: float = 0.0) -> None:
        """Fly to a point; also from the floor.

        Args:
            x: Along x (m, world).
            y: Along y (m, world).
            z: Height (m, world).
            duration: Time to get there (s), above 0.
            yaw: Heading at the end (rad).

        Raises:
            RangeError: If one of them is no finite number, or the duration not positive.
            StateError: If the motors may not run yet, or no longer; also in the last moment before the supervisor
                resets on the floor, every 30 s and 3 s after a landing.
        """
        who = self._who("command")
        x, y, z, duration, yaw = finite(who, x=x, y=y, z=z, duration=duration, yaw=yaw)
        if not duration > 0.0:
            raise RangeError(f"{who}: duration is {duration}, allowed: a number above 0 s")
        if self.is_stopped:
            return
        if not self.drone.can_fly:
            raise StateError(f"{who}: the motors may not run, state '{self.drone.supervisor_state}'")
        if is_about_to_reset(self.drone):
            raise StateError(
                f"{who}: the supervisor is about to reset on the floor and would drop this plan; command again in "
                "0.2 s, in state 'Ready to fly'"
            )
        uplink = self.drone.uplink
        if self.drone.struct.onboard.commander.priority > lib.COMMANDER_PRIORITY_HIGHLEVEL:
            # whoever flew with setpoints before, or stopped, holds the commander
            uplink.request("cf_notify_setpoint_stop")
        check(uplink.request("cf_go_to", x, y, z, yaw, duration, False, False), f"{who}({x}, {y}, {z}, {duration})")

    def command_point(self, position: Sequence[float], duration: float, yaw: float = 0.0) -> None:
        """The same for a vector (m, world), shape (3,)."""
        self.command(*three(self._who("command_point"), "position", position), duration, yaw)  # type: ignore[arg-type]

    @property
    def is_there(self) -> bool:
        """Whether the present plan has come to its end."""
        return self.drone.high_level_commander.is_trajectory_finished
