"""What an integrator is made of: the Runge-Kutta step, a random force, and what it tells of its drones."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError

Array = NDArray[np.float64]
Derivative = Callable[[float, Array], Array]


def rk4(derivative: Derivative, time: float, state: Array, dt: float) -> Array:
    """Return the state one step later.

    Args:
        derivative: Of time (s) and state.
        time: Time at the begin of the step (s).
        state: State there, any shape.
        dt: Length of the step (s).
    """
    k1 = derivative(time, state)
    k2 = derivative(time + 0.5 * dt, state + 0.5 * dt * k1)
    k3 = derivative(time + 0.5 * dt, state + 0.5 * dt * k2)
    k4 = derivative(time + dt, state + dt * k3)
    return state + dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)


def euler(derivative: Derivative, time: float, state: Array, dt: float) -> Array:
    """Return the state one forward Euler step later; arguments as of `rk4`."""
    return state + dt * derivative(time, state)


class RandomForce:
    """A seeded random force (N, world) on each drone: Gaussian, correlated over a time, constant within a step.

    The sequence of a drone depends on the seed and its index alone, not on how many others there are.
    """

    def __init__(self, sigma: float, time_constant: float = 1.0, seed: int = 0) -> None:
        """Choose the force.

        Args:
            sigma: Standard deviation per axis (N).
            time_constant: Correlation time (s); 0 draws each step by itself.
            seed: Seed.

        Raises:
            RangeError: If a number is outside its range.
        """
        if not (math.isfinite(sigma) and sigma >= 0.0):
            raise RangeError(f"sigma is {sigma}, allowed: 0 N or more")
        if not (math.isfinite(time_constant) and time_constant >= 0.0):
            raise RangeError(f"time_constant is {time_constant}, allowed: 0 s or more")
        self._sigma = sigma
        self._time_constant = time_constant
        self._seed = seed
        self._dice: list[np.random.Generator] = []
        self._force = np.zeros((0, 3))

    def step(self, count: int, dt: float) -> NDArray[np.float64]:
        """Return the force on each of `count` drones during the next `dt` seconds (N), shape (count, 3)."""
        while len(self._dice) < count:
            dice = np.random.default_rng([self._seed, len(self._dice)])
            self._dice.append(dice)
            self._force = np.vstack([self._force, self._sigma * dice.standard_normal(3)])
        force = self._force[:count].copy()
        keep = math.exp(-dt / self._time_constant) if self._time_constant > 0.0 else 0.0
        fresh = np.array([dice.standard_normal(3) for dice in self._dice[:count]])
        self._force[:count] = keep * force + self._sigma * math.sqrt(1.0 - keep * keep) * fresh
        return force


@dataclass(frozen=True)
class Odometry:
    """Pose and twist of one or many drones at an instant; `...` is () for one and (N,) for many."""

    time: float
    """Time (s)."""
    position: NDArray[np.float64]
    """Position (m, world), shape (..., 3)."""
    quat_xyzw: NDArray[np.float64]
    """Attitude, body to world, shape (..., 4)."""
    velocity: NDArray[np.float64]
    """Velocity (m/s, world), shape (..., 3)."""
    rates: NDArray[np.float64]
    """Angular velocity (rad/s, body), shape (..., 3)."""
