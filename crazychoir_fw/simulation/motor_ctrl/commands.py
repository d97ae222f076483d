"""The classes that bring a command: thrust and rates, thrust and attitude, velocity, and a point."""

from __future__ import annotations

import math
from collections.abc import Sequence

from crazychoir_fw._core import lib
from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.common.finite import finite, three
from crazychoir_fw.onboard.core import check
from crazychoir_fw.onboard.thrust import thrust_counts
from crazychoir_fw.simulation.motor_ctrl.motor_ctrl import MotorCtrl
from crazychoir_fw.simulation.supervisor_resets import is_about_to_reset


class _ThrustCtrl(MotorCtrl):
    def cmd_vel(self, linear: Sequence[float], angular: Sequence[float]) -> None:
        """The same as a Twist: thrust (N) in linear z, the other three in angular."""
        who = self._who("cmd_vel")
        _, _, f = three(who, "linear", linear)
        self.command(f, *three(who, "angular", angular))  # type: ignore[arg-type]


class MotorCtrlFPQR(_ThrustCtrl):
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


class MotorCtrlFRPY(_ThrustCtrl):
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
            # earlier setpoints, or a stop, still hold the commander
            uplink.request("cf_notify_setpoint_stop")
        check(uplink.request("cf_go_to", x, y, z, yaw, duration, False, False), f"{who}({x}, {y}, {z}, {duration})")

    def command_point(self, position: Sequence[float], duration: float, yaw: float = 0.0) -> None:
        """The same for a vector (m, world), shape (3,)."""
        self.command(*three(self._who("command_point"), "position", position), duration, yaw)  # type: ignore[arg-type]

    @property
    def is_there(self) -> bool:
        """Whether the present plan has come to its end."""
        return self.drone.high_level_commander.is_trajectory_finished
