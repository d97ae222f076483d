"""Tasks of several drones that see each other: a formation that turns and drifts, and places that are swapped."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.learning.dice import uniforms
from crazychoir_fw.learning.reading import Floats, Reading, Reference
from crazychoir_fw.learning.tasks.task import Doubles, Starts, Task
from crazychoir_fw.simulation import DroneConfig

SEEN_OF_ANOTHER = 6
"""Numbers that a drone sees of another one: relative position (m, world) and velocity (m/s, world)."""


@dataclass(frozen=True)
class SwarmTask(Task):
    """Base of tasks in which a row is a drone of one swarm: all rows begin together, in their order."""

    starts_alone: ClassVar[bool] = False

    drones: int = 4
    """How many."""
    neighbors: int = 3
    """How many others a drone sees, the nearest first."""
    radius: float = 0.9
    """Of the circle on which they stand (m)."""
    start_box: tuple[float, float, float] = (0.1, 0.1, 0.1)
    start_speed: float = 0.1
    start_tilt_deg: float = 5.0
    start_rate: float = 0.3
    start_yaw_deg: float = 10.0
    close_cost: float = 2.0
    """Per second at no distance from another drone; 0 from `close_m` on."""
    close_m: float = 0.5
    """(m)."""

    def __post_init__(self) -> None:
        super().__post_init__()
        name = type(self).__name__
        if not (isinstance(self.drones, int) and 2 <= self.drones <= 64):
            raise RangeError(f"{name}: drones is {self.drones!r}, allowed: 2 to 64")
        if not (isinstance(self.neighbors, int) and 0 <= self.neighbors < self.drones):
            raise RangeError(f"{name}: neighbors is {self.neighbors!r}, allowed: 0 to {self.drones - 1}")
        if 2.0 * self.radius * math.sin(math.pi / self.drones) < 0.4:
            raise RangeError(f"{name}: radius is {self.radius} m, allowed: at least 0.4 m between {self.drones} drones")

    def drone_config(self, name: str) -> DroneConfig:
        """Return the drone of the task; others are there for it."""
        return DroneConfig(
            name, (0.0, 0.0, 1.0), platform=self.platform, positioning=self.positioning, decks=self.decks
        )

    def _angles(self, count: int) -> Doubles:
        return 2.0 * np.pi * np.arange(count) / self.drones

    def _slots(self, angles: Doubles) -> Doubles:
        circle = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)
        return self.radius * circle + np.array(self.center)

    def starts(self, keys: NDArray[np.uint64]) -> Starts:
        """Begin close to the own place on the circle."""
        found = super().starts(keys)
        found.position += self._slots(self._angles(len(keys))) - np.array(self.center)
        return found

    def others(self, reading: Reading, is_flying: NDArray[np.bool_]) -> Floats:
        """Return what each drone sees of its nearest neighbors, as a ground station tells it, shape (N, k * 6).

        Places of drones that do not fly, and of those that are not there, are zero.
        """
        position, velocity = reading.estimate.position, reading.estimate.velocity
        offset = position[None] - position[:, None]
        distance = np.linalg.norm(offset, axis=2)
        distance[:, ~is_flying] = np.inf
        np.fill_diagonal(distance, np.inf)
        order = np.argsort(distance, axis=1, kind="stable")[:, : self.neighbors]
        rows = np.arange(len(position))[:, None]
        seen = np.concatenate([offset[rows, order], (velocity[None] - velocity[:, None])[rows, order]], axis=2)
        seen[~np.isfinite(distance[rows, order])] = 0.0
        return seen.reshape(len(position), -1).astype(np.float32)

    def reward(self, reading: Reading) -> Floats:
        """Return what a step was worth; closeness costs."""
        position = reading.truth.position
        distance = np.linalg.norm(position[None] - position[:, None], axis=2)
        np.fill_diagonal(distance, np.inf)
        close = np.square(np.maximum(0.0, 1.0 - distance / self.close_m)).sum(1)
        return (super().reward(reading) - self.close_cost / self.rate_hz * close).astype(np.float32)

    def is_over(self, reading: Reading) -> NDArray[np.bool_]:
        """Return which drones left the room, tilted too far, were stopped, or touched something."""
        return super().is_over(reading) | reading.is_touching


@dataclass(frozen=True)
class Swarm(SwarmTask):
    """Keep a circle that turns about its middle, which drifts."""

    episode_s: float = 10.0
    turn_rate: float = 0.3
    """Largest rate of the circle, either way (rad/s), drawn per episode."""
    drift: float = 0.1
    """Largest velocity of the middle, per axis (m/s)."""

    def plan(self, keys: NDArray[np.uint64]) -> Doubles:
        """Return angle, turn rate and drift, shape (n, 4); the first drone's dice count for all."""
        draw = 2.0 * uniforms(keys[:1], 3, stream=1)[0] - 1.0
        angles = self._angles(len(keys))
        common = np.array([draw[0] * self.turn_rate, draw[1] * self.drift, draw[2] * self.drift])
        return np.concatenate([angles[:, None], np.tile(common, (len(keys), 1))], axis=1)

    def reference(self, plan: Doubles, seconds: Doubles) -> Reference:
        """Return the place of each drone."""
        angle = plan[:, 0] + plan[:, 1] * seconds
        drift = np.stack([plan[:, 2], plan[:, 3], np.zeros(len(plan))], axis=1)
        outward = self._slots(angle) - np.array(self.center)
        along = plan[:, 1:2] * np.stack([-outward[:, 1], outward[:, 0], np.zeros(len(plan))], axis=1)
        position = np.array(self.center) + outward + drift * seconds[:, None]
        parts = (position, along + drift, -(plan[:, 1:2] ** 2) * outward)
        return Reference(*(part.astype(np.float32) for part in parts))


@dataclass(frozen=True)
class Swap(SwarmTask):
    """Fly to the place opposite, through all others."""

    episode_s: float = 8.0

    def plan(self, keys: NDArray[np.uint64]) -> Doubles:
        """Return the angle of the own place, shape (n, 1)."""
        return self._angles(len(keys))[:, None]

    def reference(self, plan: Doubles, seconds: Doubles) -> Reference:
        """Return the place opposite."""
        still = np.zeros((len(seconds), 3), np.float32)
        return Reference(self._slots(plan[:, 0] + np.pi).astype(np.float32), still, still)
