"""Follow a curve: a figure-8 of random size, speed and place, or a curve of the planner."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.learning.dice import uniforms
from crazychoir_fw.learning.observation import Observation
from crazychoir_fw.learning.reading import Reference
from crazychoir_fw.learning.tasks.task import Doubles, Starts, Task
from crazychoir_fw.planning.curves import Polynomial

FOLLOWING = ("position_error", "velocity_error", "reference_acceleration", "rotation", "rates", "action")
"""What a policy sees that follows a curve."""


@dataclass(frozen=True)
class Track(Task):
    """Follow x = a sin(w t), y = b sin(2 w t), or `curve`, from close to its begin."""

    observation: Observation = field(default_factory=lambda: Observation(FOLLOWING))
    episode_s: float = 8.0
    curve: Polynomial | None = None
    """A curve of the planner (`crazychoir_fw.planning`), followed from its begin and repeated; None is the figure-8."""
    width: tuple[float, float] = (0.6, 1.2)
    """Range of a, drawn per episode (m)."""
    depth: tuple[float, float] = (0.3, 0.6)
    """Range of b (m)."""
    period_s: tuple[float, float] = (5.0, 8.0)
    """Range of 2 pi / w (s)."""
    start_box: tuple[float, float, float] = (0.2, 0.2, 0.2)
    start_speed: float = 0.3
    yaw_cost: float = 0.2

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 < self.period_s[0] <= self.period_s[1]:
            raise RangeError(f"Track: period_s is {self.period_s}, allowed: two numbers above 0 that rise")

    def plan(self, keys: NDArray[np.uint64]) -> Doubles:
        """Return a, b, w and the phase at the begin of each episode, shape (n, 4)."""
        draw = uniforms(keys, 4, stream=1)
        ranges = np.array([self.width, self.depth, self.period_s])
        a, b, period = (ranges[:, 0] + draw[:, :3] * (ranges[:, 1] - ranges[:, 0])).T
        return np.stack([a, b, 2.0 * np.pi / period, 2.0 * np.pi * draw[:, 3]], axis=1)

    def starts(self, keys: NDArray[np.uint64]) -> Starts:
        """Begin close to the curve, with about its velocity."""
        found = super().starts(keys)
        begin = self.reference(self.plan(keys), np.zeros(len(keys)))
        found.position += begin.position - np.array(self.center)
        found.velocity += begin.velocity
        return found

    def reference(self, plan: Doubles, seconds: Doubles) -> Reference:
        """Return the point of the curve, its velocity and its acceleration."""
        if self.curve is not None:
            return self._of_curve(seconds)
        a, b, w, phase = plan.T
        angle = w * seconds + phase
        still = np.zeros_like(angle)
        position = np.stack([a * np.sin(angle), b * np.sin(2 * angle), still], axis=1) + np.array(self.center)
        velocity = np.stack([a * w * np.cos(angle), 2 * b * w * np.cos(2 * angle), still], axis=1)
        acceleration = np.stack([-a * w**2 * np.sin(angle), -4 * b * w**2 * np.sin(2 * angle), still], axis=1)
        return Reference(*(array.astype(np.float32) for array in (position, velocity, acceleration)))

    def _of_curve(self, seconds: Doubles) -> Reference:
        assert self.curve is not None
        times = np.mod(seconds, self.curve.duration)
        parts = (self.curve.position(times), self.curve.velocity(times), self.curve.acceleration(times))
        return Reference(*(np.asarray(part, np.float32) for part in parts))
