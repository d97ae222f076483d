"""Simple loops that turn other commands into thrust and body rates.

They stand in for the onboard controller, which an integrator does not have; gains are those of a well damped vehicle
with ideal body rates, not of the firmware.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.attitude import rotation, wrapped

Array = NDArray[np.float64]

GRAVITY = 9.81
_ATTITUDE_GAIN = 10.0  # [1/s]
_VELOCITY_GAIN = 4.0  # [1/s]
_POSITION_GAIN = 2.0  # [1/s]
_MAX_ACCELERATION = 4.0  # [m/s^2]


class Loop(Protocol):
    """Called at the begin of every step with time (s), state (..., 9 or more) and mass (kg), gravity (m/s^2).

    Returns f, p, q, r.
    """

    def __call__(self, time: float, state: Array, mass: Array, gravity: float) -> Array:
        """Return the input, shape (..., 4)."""


@dataclass
class AttitudeLoop:
    """Holds thrust (N) and roll, pitch, yaw (rad)."""

    thrust: Array  # (...,)
    rpy: Array  # (..., 3)

    def __call__(self, time: float, state: Array, mass: Array, gravity: float) -> Array:
        """See `Loop`."""
        rates = _rates_towards(rotation(self.rpy), state)
        return np.concatenate([np.broadcast_to(self.thrust, rates.shape[:-1])[..., None], rates], axis=-1)


@dataclass
class VelocityLoop:
    """Follows a velocity (m/s, world) at a yaw rate (rad/s)."""

    velocity: Array  # (..., 3)
    yaw_rate: Array  # (...,)

    def __call__(self, time: float, state: Array, mass: Array, gravity: float) -> Array:
        """See `Loop`."""
        acceleration = _VELOCITY_GAIN * (self.velocity - state[..., 6:9])
        command = _thrust_and_rates(acceleration, state[..., 5], state, mass, gravity)
        command[..., 3] += self.yaw_rate
        return command


@dataclass
class GoToLoop:
    """Flies smoothly from a state to a point and yaw within a duration, and stays there."""

    begin: float  # [s]
    duration: float  # [s]
    start: Array  # (..., 3) [m]
    start_velocity: Array  # (..., 3) [m/s]
    start_yaw: Array  # (...,) [rad]
    goal: Array  # (..., 3) [m]
    goal_yaw: Array  # (...,) [rad]

    def __call__(self, time: float, state: Array, mass: Array, gravity: float) -> Array:
        """See `Loop`."""
        position, velocity, acceleration, yaw = self.reference(time)
        wanted = acceleration + _VELOCITY_GAIN * (
            velocity - state[..., 6:9] + _POSITION_GAIN * (position - state[..., 0:3])
        )
        return _thrust_and_rates(wanted, yaw, state, mass, gravity)

    def reference(self, time: float) -> tuple[Array, Array, Array, Array]:
        """Return position, velocity, acceleration and yaw of the plan: quintic, at rest at its end."""
        T = self.duration
        s = min(max((time - self.begin) / T, 0.0), 1.0)
        way = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
        way1 = 30.0 * s**2 * (1.0 - s) ** 2 / T
        way2 = 60.0 * s * (1.0 - 3.0 * s + 2.0 * s**2) / T**2
        # share of the start velocity: 1 at the begin, 0 at the end, with all derivatives
        run = T * s * (1.0 - s) ** 3 * (1.0 + 3.0 * s)
        run1 = (1.0 - s) ** 2 * (1.0 + 2.0 * s - 15.0 * s**2)
        run2 = -12.0 * s * (1.0 - s) * (3.0 - 5.0 * s) / T
        distance = self.goal - self.start
        yaw = self.start_yaw + way * wrapped(self.goal_yaw - self.start_yaw)
        return (
            self.start + way * distance + run * self.start_velocity,
            way1 * distance + run1 * self.start_velocity,
            way2 * distance + run2 * self.start_velocity,
            yaw,
        )


def _thrust_and_rates(acceleration: Array, yaw: Array, state: Array, mass: Array, gravity: float) -> Array:
    """Return the input that turns the thrust towards an acceleration (m/s^2, world) and the nose to a yaw (rad)."""
    size = np.linalg.norm(acceleration, axis=-1, keepdims=True)
    acceleration = acceleration * np.minimum(1.0, _MAX_ACCELERATION / np.maximum(size, 1e-9))
    force = np.asarray(mass)[..., None] * (acceleration + np.array([0.0, 0.0, gravity]))
    z = force / np.linalg.norm(force, axis=-1, keepdims=True)
    heading = np.stack([np.cos(yaw), np.sin(yaw), np.zeros_like(yaw)], axis=-1)
    y = np.cross(z, heading)
    y /= np.linalg.norm(y, axis=-1, keepdims=True)
    wanted = np.stack([np.cross(y, z), y, z], axis=-1)
    thrust = np.sum(force * rotation(state[..., 3:6])[..., :, 2], axis=-1, keepdims=True)
    return np.concatenate([np.maximum(thrust, 0.0), _rates_towards(wanted, state)], axis=-1)


def _rates_towards(wanted: Array, state: Array) -> Array:
    """Return body rates (rad/s) that turn the attitude of a state towards another one, shape (..., 3)."""
    present = rotation(state[..., 3:6])
    error = np.swapaxes(wanted, -1, -2) @ present
    error = 0.5 * (error - np.swapaxes(error, -1, -2))
    return -_ATTITUDE_GAIN * np.stack([error[..., 2, 1], error[..., 0, 2], error[..., 1, 0]], axis=-1)
