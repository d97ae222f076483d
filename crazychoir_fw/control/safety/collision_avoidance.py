"""Filters between a controller and its drone: what goes in is desired, what comes out is safe.

docs/reference/crazychoir.md#9.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, Twist
from crazychoir_fw.control.safety.barrier_filter import BarrierFilter, positive
from crazychoir_fw.control.safety.double_integrator import DoubleIntegratorCBF
from crazychoir_fw.control.safety.single_integrator import SingleIntegratorCBF

Array = NDArray[np.float64]

_LEVEL = 0.01  # of the length of a body axis: less than that in the plane is no heading


class CollisionAvoidance(ABC):
    """Keeps the latest desired input, the own pose and poses of nearby drones, and returns the input that is safe now.

    One object serves one drone, arrays of shape (3,), or several at once, (N, 3). Its owner calls `step` at its own
    rate, which may be higher than that of the desired inputs.

    Attributes:
        input_topic_name: Topic of the safe input, for nodes; desired ones come on ``{topic}_des``.
    """

    input_topic_name = ""
    needs_velocity = False
    """Whether it needs velocities, and so waits for them."""

    def __init__(self, safety_filter: BarrierFilter | None = None) -> None:
        """Choose the filter.

        Args:
            safety_filter: The filter; needed.

        Raises:
            RangeError: If it is missing, or filters something else.
        """
        if not isinstance(safety_filter, self._filters):
            allowed = " or ".join(kind.__name__ for kind in self._filters)
            given = type(safety_filter).__name__
            raise RangeError(f"{type(self).__name__}: safety_filter is {given}, allowed: {allowed}")
        self.safety_filter: BarrierFilter = safety_filter
        self.current_pose = Pose()
        self.closest: Pose | Mapping[int, Pose] = {}

    @property
    @abstractmethod
    def _filters(self) -> tuple[type[BarrierFilter], ...]: ...

    def set_pose(self, pose: Pose) -> None:
        """Take the own pose."""
        self.current_pose = pose

    def set_closest(self, closest: Pose | Mapping[int, Pose]) -> None:
        """Take nearby drones: arrays of shape (..., K, 3), padded with nan, or poses by number for a single drone."""
        self.closest = closest

    @property
    def is_ready(self) -> bool:
        """Whether desired input and pose are known."""
        pose = self.current_pose
        return pose.position is not None and not (self.needs_velocity and pose.velocity is None)


class SingleIntegratorCollisionAvoidance(CollisionAvoidance):
    """Of velocities: linear part of a `Twist` in the world; angular part and z pass through."""

    input_topic_name = "cmd_vel"
    _filters = (SingleIntegratorCBF,)
    _desired: Twist | None = None

    def set_desired(self, desired: Twist | None) -> None:
        """Take the desired velocity (m/s, world)."""
        self._desired = desired

    def step(self) -> Twist | None:
        """Return the safe velocity, None before there is a desired one and a pose."""
        if self._desired is None or not self.is_ready:
            return None
        return Twist(
            self.safety_filter.filter(self._desired.linear, self.current_pose, self.closest), self._desired.angular
        )

    def standstill(self) -> Twist:
        """Return the input of a drone without data of its surroundings: zero velocity."""
        shape = np.shape(self.current_pose.position)
        return Twist(np.zeros(shape), np.zeros(shape))


class DoubleIntegratorCollisionAvoidance(CollisionAvoidance):
    """Of accelerations (m/s^2, world), shape (..., 3); z passes through."""

    input_topic_name = "acceleration"
    needs_velocity = True
    _filters = (DoubleIntegratorCBF,)
    _desired: Array | None = None

    def set_desired(self, desired: ArrayLike | None) -> None:
        """Take the desired acceleration (m/s^2, world)."""
        self._desired = None if desired is None else np.asarray(desired, float)

    def step(self) -> Array | None:
        """Return the safe acceleration, None before there is a desired one and a pose with velocity."""
        if self._desired is None or not self.is_ready:
            return None
        return self.safety_filter.filter(self._desired, self.current_pose, self.closest)

    def standstill(self) -> Array:
        """Return the acceleration (m/s^2) that stops a drone without data of its surroundings."""
        velocity = np.asarray(self.current_pose.velocity, float)
        braking = self.safety_filter.max_braking_acceleration  # type: ignore[attr-defined]
        speed = np.linalg.norm(velocity, axis=-1, keepdims=True)
        return -np.minimum(braking / np.maximum(speed, 1e-9), 1.0) * velocity


class UnicycleCollisionAvoidance(CollisionAvoidance):
    """Of robots that drive forward (m/s, linear x of a `Twist`) and turn (rad/s, angular z).

    What is kept apart is a point in front of each, which may go anywhere. Others are seen where they are: add twice
    the look-ahead to the distance if whole robots are to stay apart.
    """

    input_topic_name = "cmd_vel"
    _filters = (SingleIntegratorCBF,)
    _desired: Twist | None = None

    def __init__(self, safety_filter: BarrierFilter | None = None, look_ahead: float = 0.1) -> None:
        """Choose the filter.

        Args:
            safety_filter: Filter of velocities; needed.
            look_ahead: How far in front of a robot its point is (m).

        Raises:
            RangeError: If the filter is missing or of another kind, or the distance not above zero.
        """
        super().__init__(safety_filter)
        self.look_ahead = positive("look_ahead", look_ahead, "m")

    def set_desired(self, desired: Twist | None) -> None:
        """Take forward velocity and turning rate."""
        self._desired = desired

    def step(self) -> Twist | None:
        """Return safe ones, None before there are desired ones and a pose with attitude."""
        pose = self.current_pose
        if self._desired is None or not self.is_ready or pose.orientation is None:
            return None
        ahead = _heading(np.asarray(pose.orientation))
        left = np.stack([-ahead[..., 1], ahead[..., 0]], axis=-1)
        forward, turning = np.asarray(self._desired.linear)[..., 0], np.asarray(self._desired.angular)[..., 2]
        wish = forward[..., None] * ahead + self.look_ahead * turning[..., None] * left
        point = np.array(pose.position, float)
        point[..., :2] += self.look_ahead * ahead
        safe = self.safety_filter.filter(wish, Pose(position=point), self.closest)
        linear, angular = np.zeros(point.shape), np.zeros(point.shape)
        linear[..., 0] = np.sum(ahead * safe, axis=-1)
        angular[..., 2] = np.sum(left * safe, axis=-1) / self.look_ahead
        return Twist(linear, angular)

    def standstill(self) -> Twist:
        """Return the input of a robot without data of its surroundings: zero velocity."""
        shape = np.shape(self.current_pose.position)
        return Twist(np.zeros(shape), np.zeros(shape))


def _heading(quat_xyzw: Array) -> Array:
    """Return where body x points in the plane, length 1, shape (..., 2)."""
    x, y, z, w = np.moveaxis(quat_xyzw, -1, 0)
    aside = np.stack([1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w)], axis=-1)
    length = np.linalg.norm(aside, axis=-1, keepdims=True)
    return np.where(length > _LEVEL, aside / np.maximum(length, _LEVEL), np.array([1.0, 0.0]))
