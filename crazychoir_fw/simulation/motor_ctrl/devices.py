"""What a program that flies one drone can read of it: pose, motion, inertial sensors, camera, motors, battery."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.simulation.drone import Drone
from crazychoir_fw.simulation.world_base import WorldBase

_STANDARD_GRAVITY = 9.81  # m/s^2, one g of the onboard software
_FULL_RATIO = 65535.0


class Devices:
    """The devices of one drone. World frame: x, y level, z up; body frame: x forward, y left, z up.

    What a name does not say is the truth, as the GPS and the inertial unit of a simulator tell it; `gyro` and
    `accelerometer` are what the drone's own sensors say, with their noise, bias and filters.
    """

    drone: Drone
    """The drone that is flown: parameters, logs and cflib's commanders are there."""
    world: WorldBase
    """The world that it flies in."""

    # ---------------------------------------------------------------- time

    @property
    def time(self) -> float:
        """Simulated time (s)."""
        return self.world.time

    @property
    def dt(self) -> float:
        """Simulated time from one step to the next (s)."""
        return 1.0 / self.rate_hz  # type: ignore[attr-defined]

    # ---------------------------------------------------------------- GPS: the true pose and motion

    @property
    def position(self) -> NDArray[np.float64]:
        """Position (m, world), shape (3,)."""
        return self.drone.true_position

    @property
    def velocity(self) -> NDArray[np.float64]:
        """Velocity (m/s, world), shape (3,)."""
        return self.drone.true_velocity

    @property
    def quat_xyzw(self) -> NDArray[np.float64]:
        """Attitude, body to world, as a quaternion (x, y, z, w), shape (4,)."""
        return np.roll(self.drone.true_quat_wxyz, -1)

    @property
    def rotation(self) -> NDArray[np.float64]:
        """Attitude, body to world, as a matrix, shape (3, 3)."""
        w, x, y, z = self.drone.true_quat_wxyz.tolist()
        return np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )

    @property
    def roll_pitch_yaw(self) -> NDArray[np.float64]:
        """Attitude (rad), shape (3,): right-handed, so that positive pitch lowers the nose."""
        w, x, y, z = self.drone.true_quat_wxyz.tolist()
        roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
        pitch = math.asin(min(max(2 * (w * y - z * x), -1.0), 1.0))
        yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
        return np.array([roll, pitch, yaw])

    @property
    def body_rates(self) -> NDArray[np.float64]:
        """Angular velocity (rad/s, body), shape (3,)."""
        return self.drone.true_rates

    @property
    def specific_force(self) -> NDArray[np.float64]:
        """Acceleration without gravity (m/s^2, body), shape (3,): (0, 0, 9.81) in hover."""
        acceleration = self.drone.true_acceleration - self.world.model.opt.gravity
        return self.rotation.T @ acceleration

    # ---------------------------------------------------------------- what the sensors on board say

    @property
    def gyro(self) -> NDArray[np.float64]:
        """Angular velocity by the gyroscope (rad/s, body), shape (3,): calibrated and filtered on board."""
        gyro = self._onboard.sensors.data.gyro
        return np.radians([gyro.x, gyro.y, gyro.z])

    @property
    def accelerometer(self) -> NDArray[np.float64]:
        """Specific force by the accelerometer (m/s^2, body), shape (3,): scaled and filtered on board."""
        acc = self._onboard.sensors.data.acc
        return _STANDARD_GRAVITY * np.array([acc.x, acc.y, acc.z])

    @property
    def estimated_position(self) -> NDArray[np.float64]:
        """Position by the onboard state estimator (m, world), shape (3,)."""
        return self.drone.estimated_position

    @property
    def estimated_velocity(self) -> NDArray[np.float64]:
        """Velocity by the onboard state estimator (m/s, world), shape (3,)."""
        velocity = self._onboard.estimate.velocity
        return np.array([velocity.x, velocity.y, velocity.z])

    def camera(self, name: str = "fpv", width: int = 320, height: int = 240) -> NDArray[np.uint8]:
        """Return what a camera sees now, shape (height, width, 3): a camera of the drone, or one of the world.

        Raises:
            RenderingError: If there is no OpenGL on this machine.
            ValueError: If there is no such camera.
        """
        return self.drone.camera(name, width, height)

    # ---------------------------------------------------------------- motors and battery

    @property
    def motor_ratios(self) -> NDArray[np.float64]:
        """What the onboard software sets the four motors to, in [0, 1], shape (4,)."""
        return np.array(list(self._onboard.motors.list)) / _FULL_RATIO

    @property
    def rotor_rpm(self) -> NDArray[np.float64]:
        """Speed of the four rotors (rpm), shape (4,)."""
        return np.array(list(self.drone.struct.vehicle.rotors.rpm))

    @property
    def rotor_thrust(self) -> NDArray[np.float64]:
        """Thrust of the four rotors (N), shape (4,)."""
        return np.array(list(self.drone.struct.vehicle.rotors.thrust))

    @property
    def battery_voltage(self) -> float:
        """Voltage at the terminals of the battery (V)."""
        return self.drone.battery_voltage

    @property
    def battery_charge(self) -> float:
        """Charge left in the battery, 1 = full."""
        return float(self.drone.struct.vehicle.battery.charge)

    @property
    def mass(self) -> float:
        """Mass of the body (kg)."""
        return self.drone.mass

    @property
    def weight(self) -> float:
        """Weight of the body (N): the thrust of a hover."""
        return self.mass * math.hypot(*self.world.model.opt.gravity)

    @property
    def max_thrust(self) -> float:
        """Thrust of the four motors at full command (N), by the thrust curve of the platform."""
        return self._max_thrust

    _max_thrust: float

    @property
    def _onboard(self) -> Any:
        return self.drone.struct.onboard
