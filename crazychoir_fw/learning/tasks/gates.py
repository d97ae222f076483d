"""Fly laps through the gates of a scene, as fast as they are passed."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.learning.dice import uniforms
from crazychoir_fw.learning.observation import Observation
from crazychoir_fw.learning.reading import Floats, Reading, Reference
from crazychoir_fw.learning.tasks.task import Doubles, Starts, Task, quat_of

SEEN = ("position_error", "velocity", "reference_acceleration", "rotation", "rates", "action")
"""What a policy sees; the reference is the middle of the next gate, its acceleration the way to the gate behind it."""

_NEXT, _DISTANCE, _ALONG = 0, 1, 2  # columns of a plan


@dataclass(frozen=True)
class Gates(Task):
    """Pass gates in their order, again and again; whatever is touched ends the flight."""

    scene: str = "gates"
    observation: Observation = field(default_factory=lambda: Observation(SEEN))
    episode_s: float = 10.0
    low: tuple[float, float, float] = (-3.0, -3.0, 0.15)
    gates: tuple[tuple[float, float, float, float], ...] = (
        (1.8, 0.0, 0.8, 90.0),
        (0.556, 1.712, 1.1, 162.0),
        (-1.456, 1.058, 1.4, 234.0),
        (-1.456, -1.058, 1.1, 306.0),
        (0.556, -1.712, 0.8, 18.0),
    )
    """Middle x, y, z (m, world) and the heading in which each is flown through (deg), in order."""
    half_width_m: float = 0.33
    """A gate is passed within so much of its middle, sideways and upward (m)."""
    progress_reward: float = 3.0
    """Per meter nearer to the next gate."""
    pass_reward: float = 2.0
    """Per gate that is passed."""
    start_speed: float = 0.3
    near_reward: float = 0.0
    far_reward: float = 0.2
    speed_cost: float = 0.0
    yaw_cost: float = 0.0

    def _middles(self) -> Doubles:
        return np.array([gate[:3] for gate in self.gates])

    def _headings(self) -> Doubles:
        angle = np.radians([gate[3] for gate in self.gates])
        return np.stack([np.cos(angle), np.sin(angle), np.zeros(len(angle))], axis=1)

    def plan(self, keys: NDArray[np.uint64]) -> Doubles:
        """Return the next gate, its distance (m) and the way past its plane (m), shape (n, 3)."""
        first = np.floor(uniforms(keys, 1, stream=1)[:, 0] * len(self.gates))
        return np.stack([first, np.full(len(keys), np.nan), np.full(len(keys), np.nan)], axis=1)

    def starts(self, keys: NDArray[np.uint64]) -> Starts:
        """Begin 0.8 to 1.2 m before the first gate."""
        draw = 2.0 * uniforms(keys, 12) - 1.0
        first = self.plan(keys)[:, _NEXT].astype(int)
        heading = self._headings()[first]
        tilt = np.radians(self.start_tilt_deg)
        yaw = np.arctan2(heading[:, 1], heading[:, 0])
        return Starts(
            position=self._middles()[first] - heading * (1.0 + 0.2 * draw[:, :1]) + 0.15 * draw[:, 1:4],
            quat_wxyz=quat_of(draw[:, 4] * tilt, draw[:, 5] * tilt, yaw),
            velocity=draw[:, 6:9] * self.start_speed,
            rates=draw[:, 9:12] * self.start_rate,
        )

    def reference(self, plan: Doubles, seconds: Doubles) -> Reference:
        """Return the middle of the next gate, and in place of an acceleration the way from it to the one behind."""
        del seconds
        number = plan[:, _NEXT].astype(int)
        middles = self._middles()
        behind = middles[(number + 1) % len(self.gates)] - middles[number]
        still = np.zeros_like(behind, np.float32)
        return Reference(middles[number].astype(np.float32), still, behind.astype(np.float32))

    def advance(self, plan: Doubles, reading: Reading) -> Floats:
        """Notice passed gates; return what progress was worth."""
        position = reading.truth.position.astype(np.float64)
        number = plan[:, _NEXT].astype(int)
        offset = position - self._middles()[number]
        along = np.einsum("ij,ij->i", offset, self._headings()[number])
        distance = np.linalg.norm(offset, axis=1)
        aside = np.sqrt(np.maximum(0.0, distance**2 - along**2 - offset[:, 2] ** 2))
        is_inside = (aside < self.half_width_m) & (np.abs(offset[:, 2]) < self.half_width_m)
        has_passed = (plan[:, _ALONG] < 0.0) & (along >= 0.0) & is_inside
        gained = np.nan_to_num(plan[:, _DISTANCE] - distance)
        plan[:, _NEXT] = np.where(has_passed, (number + 1) % len(self.gates), number)
        new = position - self._middles()[plan[:, _NEXT].astype(int)]
        plan[:, _DISTANCE] = np.linalg.norm(new, axis=1)
        plan[:, _ALONG] = np.einsum("ij,ij->i", new, self._headings()[plan[:, _NEXT].astype(int)])
        return (self.progress_reward * gained + self.pass_reward * has_passed).astype(np.float32)

    def is_over(self, reading: Reading) -> NDArray[np.bool_]:
        """Return which flights left the room, tilted too far, were stopped, or touched something."""
        return super().is_over(reading) | reading.is_touching
