"""`RadioHandlerXYZ`: go-to by the planner on board."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from crazychoir_fw.errors import RangeError
from crazychoir_fw.finite import finite, three
from crazychoir_fw.radio.crazyflie import LinkedCrazyflie
from crazychoir_fw.radio.drone import RadioDrone
from crazychoir_fw.radio.handler import RadioHandler
from crazychoir_fw.radio.modes import Mode
from crazychoir_fw.radio.vel import KALMAN, POSE_DEVIATION


class XYZDrone(RadioDrone):
    """Takes a point and a duration."""

    presets: ClassVar[Mapping[str, Any]] = {
        "commander.enHighLevel": 1,
        "stabilizer.estimator": KALMAN,
        "locSrv.extQuatStdDev": POSE_DEVIATION,
    }
    needs_position = True
    silences: ClassVar[tuple[str, ...]] = ("nothing",)

    def command(self, x: float, y: float, z: float, duration: float, yaw: float = 0.0) -> bool:
        """Fly to a point and stay there; also from the floor. The planner on board holds it without further packets.

        The first command waits until the motors may run, up to `ready_timeout_s`, arming the drone where it must be.

        Args:
            x: Along x (m, world).
            y: Along y (m, world).
            z: Height (m, world).
            duration: Time to get there (s), above 0.
            yaw: Heading at the end (rad).

        Returns:
            Whether it is taken.

        Raises:
            RangeError: If one of them is no finite number, the duration is not positive, or the point is outside of a
                safety area that refuses.
            StateError: If the motors may not run; the text says why.
        """
        who = self._call("command")
        x, y, z, duration, yaw = finite(who, x=x, y=y, z=z, duration=duration, yaw=yaw)
        if not duration > 0.0:
            raise RangeError(f"{who}: duration is {duration}, allowed: a number above 0 s")
        if self._options.safety_area is not None:
            x, y, z = self._options.safety_area.goal(who, (x, y, z))
        if self.mode is not Mode.READY or not self.is_connected:
            return False
        if not self._flight.is_ready:
            self.make_ready()

        def send(cf: LinkedCrazyflie) -> None:
            self._sender.release_if_streamed(cf)
            cf.high_level_commander.go_to(x, y, z, yaw, duration, relative=False)

        return self._flight.send_goal(send)  # it may have been stopped meanwhile

    def command_point(self, position: Sequence[float], duration: float, yaw: float = 0.0) -> bool:
        """The same for a vector (m, world), shape (3,)."""
        return self.command(*three(self._call("command_point"), "position", position), duration, yaw)


class RadioHandlerXYZ(RadioHandler):
    """Sends drones to points (m, world), which their planners on board fly to; the twin of `MotorCtrlXYZ`."""

    drone_class = XYZDrone
    defaults: ClassVar[Mapping[str, Any]] = {"on_silence": "nothing"}
