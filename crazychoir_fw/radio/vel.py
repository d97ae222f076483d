"""`RadioHandlerVel`: velocity in the world."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.finite import finite, limited, three
from crazychoir_fw.radio.crazyflie import LinkedCrazyflie
from crazychoir_fw.radio.drone import RadioDrone
from crazychoir_fw.radio.handler import RadioHandler

KALMAN = 2
SELF_POSITIONED = {"odometry_hz": 50.0, "forwards_poses": False}
"""Options of drones that find their position by themselves, and tell it."""
POSE_DEVIATION = 0.06  # of the quaternion of a pose from outside


class VelDrone(RadioDrone):
    """Takes a velocity and a yaw rate."""

    presets: ClassVar[Mapping[str, Any]] = {"stabilizer.estimator": KALMAN, "locSrv.extQuatStdDev": POSE_DEVIATION}
    needs_position = True
    max_speed: float
    """Largest velocity along each axis (m/s)."""
    max_yaw_rate: float
    """Largest yaw rate (rad/s)."""

    def command(self, vx: float, vy: float, vz: float, yaw_rate: float = 0.0) -> bool:
        """Give a command; it is repeated until the next one, also when it is to stand still.

        A drone on the floor takes off with the first velocity upward; one that must be armed is armed.

        Args:
            vx: Velocity along x (m/s, world).
            vy: Velocity along y (m/s, world).
            vz: Velocity along z (m/s, world).
            yaw_rate: Turn (rad/s), positive to the left.

        Returns:
            Whether it is taken.

        Raises:
            RangeError: If one of them is no finite number, or it leads out of a safety area that refuses.
        """
        vx, vy, vz, yaw_rate = finite(self._call("command"), vx=vx, vy=vy, vz=vz, yaw_rate=yaw_rate)
        velocity = tuple(limited(value, self.max_speed) for value in (vx, vy, vz))
        turn = math.degrees(limited(yaw_rate, self.max_yaw_rate))
        area = self._options.safety_area
        position = self.position
        refuses = area is not None and area.commands == "refuse" and position is not None
        if refuses and area.leads_out(position, velocity):
            raise RangeError(f"{self._call('command')}: {velocity} m/s leads out of the safety area {area}")

        def send(cf: LinkedCrazyflie) -> None:
            # bent when it is sent, and again with each repetition: the drone moves on meanwhile
            cf.commander.send_velocity_world_setpoint(*self._pose_cache.inside(velocity), turn)

        taken = self._flight.give(send)
        if taken:
            self._flight.arm_in_passing()
        return taken

    def cmd_vel(self, linear: Sequence[float], angular: Sequence[float]) -> bool:
        """The same as a Twist: velocity (m/s, world) in linear, yaw rate (rad/s) in angular z."""
        _, _, yaw_rate = three(self._call("cmd_vel"), "angular", angular)
        return self.command(*three(self._call("cmd_vel"), "linear", linear), yaw_rate)


class RadioHandlerVel(RadioHandler):
    """Flies drones by velocity (m/s, world) and yaw rate (rad/s); the twin of `MotorCtrlVel`.

    Limits: `max_speed` along each axis (1 m/s) and `max_yaw_rate` (pi rad/s); more is cut.
    """

    limits: ClassVar[Mapping[str, float]] = {"max_speed": 1.0, "max_yaw_rate": math.pi}
    drone_class = VelDrone


class RadioHandlerVelLightHouse(RadioHandlerVel):
    """`RadioHandlerVel` with odometry by the drones' own estimators, and without poses from outside."""

    defaults: ClassVar[Mapping[str, Any]] = {**RadioHandlerVel.defaults, **SELF_POSITIONED}
