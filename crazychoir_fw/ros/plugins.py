"""A world whose drones are flown by motor controls (`MotorCtrl`), for the simulation node."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import CrazychoirError, RangeError
from crazychoir_fw.common.messages import Pose, TrajectoryPoint, Twist
from crazychoir_fw.simulation import World
from crazychoir_fw.simulation.motor_ctrl import MotorCtrlXYZ
from crazychoir_fw.simulation.swarm_views import swarm_views

COMMANDS = {"fpqr": "MotorCtrlFPQR", "frpy": "MotorCtrlFRPY", "vel": "MotorCtrlVel", "xyz": "MotorCtrlXYZ"}
"""Which motor control takes which command."""


class PluginHost:
    """A world and its motor controls: poses out, commands in. Same methods as the backends of experiments."""

    def __init__(self, world: World, odometry: str = "estimate") -> None:
        """Take over a world.

        Args:
            world: Every drone of it has a motor control.
            odometry: Source of `poses`: ``estimate`` of the onboard filter, or ``truth``.

        Raises:
            RangeError: If a drone has no motor control, or there is no such odometry.
        """
        if odometry not in ("estimate", "truth"):
            raise RangeError(f"odometry is {odometry!r}, allowed: estimate, truth")
        for drone in world.drones:
            if drone.motor_ctrl is None:
                raise RangeError(f"{drone.id}: has no motor_ctrl, allowed: {', '.join(COMMANDS.values())} or your own")
        self.world = world
        self.names = [drone.id for drone in world.drones]
        self._odometry = odometry
        self._log = swarm_views(world)
        self._qpos = np.array([drone.qpos_address for drone in world.drones])[:, None] + np.arange(7)
        self._qvel = np.array([drone.qvel_address for drone in world.drones])[:, None] + np.arange(6)
        self._xyz: dict[int, TrajectoryPoint] = {}

    @property
    def time(self) -> float:
        """Simulated time (s)."""
        return self.world.time

    def poses(self) -> Pose:
        """Return the odometry of all drones, arrays of shape (N, …)."""
        return self.truth() if self._odometry == "truth" else self._estimate()

    def truth(self) -> Pose:
        """Return the true poses of all drones, arrays of shape (N, …)."""
        qpos, qvel = self.world.data.qpos[self._qpos], self.world.data.qvel[self._qvel]
        return Pose(qpos[:, :3], np.roll(qpos[:, 3:], -1, axis=1), qvel[:, :3], qvel[:, 3:], self.time)

    def _estimate(self) -> Pose:
        return Pose(
            self._columns("stateEstimate.x", "stateEstimate.y", "stateEstimate.z"),
            self._columns(*(f"stateEstimate.q{axis}" for axis in "xyzw")),
            self._columns("stateEstimate.vx", "stateEstimate.vy", "stateEstimate.vz"),
            np.radians(self._columns("gyro.x", "gyro.y", "gyro.z")),
            self.time,
        )

    def imu(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return readings of gyroscopes (rad/s) and accelerometers (m/s^2), shape (N, 3) each."""
        return np.radians(self._columns("gyro.x", "gyro.y", "gyro.z")), 9.81 * self._columns("acc.x", "acc.y", "acc.z")

    def _columns(self, *names: str) -> NDArray[np.float64]:
        return np.stack([self._log[name] for name in names], axis=-1).astype(float)

    def send(self, indices: Sequence[int], twist: Twist, kind: str) -> None:
        """Hand commands to motor controls; `twist` has arrays of shape (len(indices), 3)."""
        del kind  # the motor control has a fixed kind of command
        for index, linear, angular in zip(indices, twist.linear.tolist(), twist.angular.tolist(), strict=True):
            self.world.drones[index].motor_ctrl.cmd_vel(linear, angular)

    def go_to(self, index: int, point: TrajectoryPoint) -> None:
        """Fly to a point by the planner on board; a drone that cannot yet does so as soon as it can."""
        self._xyz[index] = point
        self._try(index)

    def _try(self, index: int) -> None:
        control, point = self.world.drones[index].motor_ctrl, self._xyz[index]
        if not isinstance(control, MotorCtrlXYZ):
            raise RangeError(f"{self.names[index]}: {type(control).__name__} takes no points, allowed: MotorCtrlXYZ")
        try:
            control.command(*point.position.tolist(), max(point.time_s, 1e-3))
        except RangeError:
            del self._xyz[index]
            raise
        except CrazychoirError:  # not ready: again after the next step
            return
        del self._xyz[index]

    def advance(self, seconds: float) -> None:
        """Let time go on."""
        self.world.run(seconds)
        for index in list(self._xyz):
            self._try(index)

    def stop(self, indices: Sequence[int]) -> None:
        """Motors off, until `resume`."""
        for index in indices:
            self.world.drones[index].motor_ctrl.stop()

    def resume(self, indices: Sequence[int]) -> None:
        """Take commands again."""
        for index in indices:
            self.world.drones[index].motor_ctrl.resume()

    def close(self) -> None:
        """Nothing to close."""
