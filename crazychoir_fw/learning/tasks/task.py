"""The base of all tasks: what flies, what is seen and done, how it begins, when it ends and what it is worth.

Every number is a field with its unit; every step is a method of arrays with one row per flight. A task of your own
overrides what differs, and is given to the environments in place of ours.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.learning.action import Action, ThrustRates
from crazychoir_fw.learning.dice import uniforms
from crazychoir_fw.learning.observation import Observation
from crazychoir_fw.learning.onboard_camera import OnboardCamera
from crazychoir_fw.learning.reading import Floats, Reading, Reference
from crazychoir_fw.simulation import DroneConfig

RATES_HZ = (25, 40, 50, 100, 125, 200, 250, 500)
"""Rates of a policy: whole milliseconds between two actions."""

Doubles = NDArray[np.float64]


@dataclass
class Starts:
    """How episodes begin, a row each."""

    position: Doubles
    """(m, world), shape (n, 3)."""
    quat_wxyz: Doubles
    """Body to world, shape (n, 4)."""
    velocity: Doubles
    """(m/s, world), shape (n, 3)."""
    rates: Doubles
    """(rad/s, body), shape (n, 3)."""


@dataclass(frozen=True)
class Task:
    """Base of all tasks."""

    starts_alone: ClassVar[bool] = True
    """Whether a row of `starts` and `plan` depends on its own key alone; otherwise all flights begin together."""

    # what flies
    rate_hz: int = 100
    """How often the policy acts (Hz), one of `RATES_HZ`."""
    episode_s: float = 5.0
    """An episode is truncated after so long (s)."""
    scene: str = "arena"
    """As of `World`."""
    platform: str = "cf2"
    """``cf2`` or ``cf21bl``."""
    positioning: str = "mocap"
    """What tells the drone where it is, as of `DroneConfig`."""
    decks: Sequence[str] = ()
    """Such as ``multiranger``, for the block ``ranges``."""
    vary: Mapping[str, Any] | str | Path = field(default_factory=dict)
    """How drones differ: the `vary:` block of a campaign, or the path of a campaign file."""
    variants: int = 32
    """How many different drones; each has sensor errors of its own, and what `vary` draws."""

    # what the policy sees and does
    action: Action = field(default_factory=ThrustRates)
    """A kind of `crazychoir_fw.learning.action`."""
    observation: Observation = field(default_factory=Observation)
    """What the policy sees."""
    critic: Observation | None = None
    """What only a critic sees, such as the truth; observations are then a dictionary with ``policy`` and ``critic``."""
    camera: OnboardCamera | None = None
    """Pictures beside what the policy sees; observations are then a dictionary with ``policy`` and ``camera``."""

    # where an episode ends
    low: tuple[float, float, float] = (-2.5, -2.5, 0.15)
    """The lower corner of the room in which a flight goes on (m, world)."""
    high: tuple[float, float, float] = (2.5, 2.5, 3.0)
    """The upper corner (m, world)."""
    max_tilt_deg: float = 120.0
    """A flight ends beyond this tilt (deg)."""

    # what a step is worth, per second of flight
    near_reward: float = 1.0
    """At the reference; falls off with the distance as exp(-(d / near_m)^2)."""
    near_m: float = 0.15
    """(m)."""
    far_reward: float = 1.0
    """At the reference; falls linearly to 0 at far_m, and shows the way from afar."""
    far_m: float = 2.0
    """(m)."""
    speed_cost: float = 0.1
    """Per m/s of velocity error."""
    rate_cost: float = 0.03
    """Per rad/s of body rates."""
    yaw_cost: float = 0.2
    """Per (1 - cos yaw)."""
    action_cost: float = 0.02
    """Per squared action."""
    change_cost: float = 0.3
    """Per squared change of the action since the step before."""
    end_cost: float = 5.0
    """Once, where a flight ends early."""

    # how an episode begins
    start_box: tuple[float, float, float] = (0.8, 0.8, 0.5)
    """Half widths of the box about `center` in which flights begin (m)."""
    center: tuple[float, float, float] = (0.0, 0.0, 1.2)
    """(m, world)."""
    start_speed: float = 0.5
    """Largest component of the velocity at the begin (m/s)."""
    start_tilt_deg: float = 15.0
    """Largest tilt at the begin (deg)."""
    start_rate: float = 1.0
    """Largest component of the body rates at the begin (rad/s)."""
    start_yaw_deg: float = 45.0
    """Largest heading at the begin, either way (deg)."""

    def __post_init__(self) -> None:
        name = type(self).__name__
        if self.rate_hz not in RATES_HZ:
            raise RangeError(f"{name}: rate_hz is {self.rate_hz!r}, allowed: {', '.join(map(str, RATES_HZ))}")
        if not (isinstance(self.variants, int) and 1 <= self.variants <= 4096):
            raise RangeError(f"{name}: variants is {self.variants!r}, allowed: 1 to 4096")
        if not (math.isfinite(self.episode_s) and self.episode_s * self.rate_hz >= 1.0):
            raise RangeError(f"{name}: episode_s is {self.episode_s!r}, allowed: at least one step of the policy")
        if not all(a < b for a, b in zip(self.low, self.high, strict=True)):
            raise RangeError(f"{name}: low is {self.low} and high {self.high}, allowed: low below high")

    # ------------------------------------------------------------------------------------ what flies

    @property
    def ticks(self) -> int:
        """Milliseconds between two actions."""
        return 1000 // self.rate_hz

    @property
    def steps(self) -> int:
        """Actions of a whole episode."""
        return round(self.episode_s * self.rate_hz)

    def drone_config(self, name: str) -> DroneConfig:
        """Return the drone of the task; no other drone is there for it."""
        return DroneConfig(
            name,
            (0.0, 0.0, 1.0),
            platform=self.platform,
            positioning=self.positioning,
            decks=self.decks,
            attributes={"isolated": "on"},
        )

    # ----------------------------------------------------------------------------------- an episode

    def starts(self, keys: NDArray[np.uint64]) -> Starts:
        """Return how episodes begin.

        Args:
            keys: A key per episode, for `uniforms`; stream 0 is that of the starts.
        """
        draw = 2.0 * uniforms(keys, 12) - 1.0
        tilt = np.radians(self.start_tilt_deg)
        return Starts(
            position=np.array(self.center) + draw[:, :3] * np.array(self.start_box),
            quat_wxyz=quat_of(draw[:, 6] * tilt, draw[:, 7] * tilt, draw[:, 8] * np.radians(self.start_yaw_deg)),
            velocity=draw[:, 3:6] * self.start_speed,
            rates=draw[:, 9:12] * self.start_rate,
        )

    def plan(self, keys: NDArray[np.uint64]) -> Doubles:
        """Return what `reference` has to know of each episode, shape (n, k); stream 1 of the keys is for it."""
        return np.zeros((len(keys), 0))

    @property
    def plan_size(self) -> int:
        """Numbers per episode of `plan`."""
        return self.plan(np.zeros(1, np.uint64)).shape[1]

    def reference(self, plan: Doubles, seconds: Doubles) -> Reference:
        """Return what is to be followed; by default `center`.

        Args:
            plan: Rows of `plan`, shape (N, k).
            seconds: Time since the begin of each episode (s), shape (N,).
        """
        del plan
        shape = len(seconds), 3
        still = np.broadcast_to(np.float32(0.0), shape)
        return Reference(np.broadcast_to(np.array(self.center, np.float32), shape), still, still)

    def advance(self, plan: Doubles, reading: Reading) -> Floats | float:
        """Change rows of `plan` in place after a step, and return what that was worth beside `reward`, shape (N,)."""
        del plan, reading
        return 0.0

    def reward(self, reading: Reading) -> Floats:
        """Return what a step was worth, shape (N,)."""
        truth, reference = reading.truth, reading.reference
        distance = _length(reference.position - truth.position)
        near = np.exp(-np.square(distance / np.float32(self.near_m)))
        far = np.maximum(0.0, 1.0 - distance / np.float32(self.far_m))
        change = reading.action - reading.previous_action
        cosine = truth.rotation[:, 0] / np.maximum(1e-6, np.hypot(truth.rotation[:, 0], truth.rotation[:, 3]))
        cost = (
            self.speed_cost * _length(reference.velocity - truth.velocity)
            + self.rate_cost * _length(truth.rates)
            + self.yaw_cost * (1.0 - cosine)
            + self.action_cost * _squared(reading.action)
            + self.change_cost * _squared(change)
        )
        return ((self.near_reward * near + self.far_reward * far - cost) / self.rate_hz).astype(np.float32)

    def is_over(self, reading: Reading) -> NDArray[np.bool_]:
        """Return which flights end early: out of the room, tilted too far, or stopped by the onboard software."""
        position = reading.truth.position
        inside = (position > np.array(self.low, np.float32)) & (position < np.array(self.high, np.float32))
        is_tilted = reading.truth.rotation[:, 8] < math.cos(math.radians(self.max_tilt_deg))
        is_inside = inside[:, 0] & inside[:, 1] & inside[:, 2]
        return ~is_inside | is_tilted | reading.is_out


def _squared(vectors: Floats) -> Floats:
    """Return sums of squares, shape (N,); a reduction over three columns takes five times as long."""
    return np.asarray(np.einsum("ij,ij->i", vectors, vectors))


def _length(vectors: Floats) -> Floats:
    return np.sqrt(_squared(vectors))


def quat_of(roll: Doubles, pitch: Doubles, yaw: Doubles) -> Doubles:
    """Return quaternions (w, x, y, z), shape (n, 4), of yaw, pitch and roll (rad), turned in this order."""
    cr, sr, cp, sp = np.cos(roll / 2), np.sin(roll / 2), np.cos(pitch / 2), np.sin(pitch / 2)
    cy, sy = np.cos(yaw / 2), np.sin(yaw / 2)
    return np.stack(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ],
        axis=1,
    )
