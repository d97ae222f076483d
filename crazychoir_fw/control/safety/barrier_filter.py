"""What the safety filters have in common: the nearest input that keeps every barrier function from falling too fast."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.control.safety.half_planes import HalfPlanes
from crazychoir_fw.control.safety.neighbor_sensing import ClosestRobotGetter, stacked
from crazychoir_fw.control.safety.relative_motion import RelativeMotion

Array = NDArray[np.float64]

_MIN_LOSS = 1e-6  # of the limit: less is rounding


class BarrierFilter(ABC):
    """Changes a desired input as little as possible so that no agent comes nearer than `distance`, horizontally.

    Two agents that meet head-on may block each other indefinitely: each wants to go where the other is. With
    `keep_right`, the filter redirects the part of an input that it takes away to the right, as far as that is safe.
    Agents that block each other then turn about each other, all in the same direction.

    Attributes:
        distance: Least distance of two agents (m), center to center.
        keep_right: Which part of what is taken away of an input goes to its right; 0 waits.
        braking: Which agents braked in the last call, shape (...).
        least_barrier: Min value of their barriers in the last call, shape (...); infinite without nearby agents.
    """

    filters: ClassVar[str]
    """What it filters: acceleration, within a position law, or velocity, behind a controller."""
    distance: float
    keep_right: float

    def __init__(self, distance: float, keep_right: float = 0.0) -> None:
        self.distance = positive("distance", distance, "m")
        if not 0.0 <= keep_right < np.inf:
            raise RangeError(f"keep_right is {keep_right}, allowed: 0 or more")
        self.keep_right = float(keep_right)
        self.braking: NDArray[np.bool_] = np.zeros((), dtype=bool)
        self.least_barrier: Array = np.full((), np.inf)

    def filter(self, desired: ArrayLike, pose: Pose, others: Pose | Mapping[int, Pose]) -> Array:
        """Return the input that is safe.

        Args:
            desired: Desired input, shape (..., 2), or (..., 3) of which z passes through.
            pose: Own position (m) and velocity (m/s), shape (..., 3).
            others: Nearby agents: arrays of shape (..., K, 3), padded with nan, or poses by number for a single agent.

        Returns:
            The input, of the shape of the desired one.

        Raises:
            RangeError: If shapes do not fit, or a position or velocity that is needed is missing.
        """
        if isinstance(others, Mapping):
            others = stacked(dict(others))
        wish = np.array(desired, dtype=np.float64)
        if wish.ndim == 0 or wish.shape[-1] not in (2, 3):
            raise RangeError(f"desired input has shape {wish.shape}, allowed: (..., 2) or (..., 3)")
        lead = wish.shape[:-1]
        own_position, own_velocity = self._known("own pose", pose, lead)
        position, velocity = self._known("other poses", others, None)
        everywhere = (*lead, *position.shape[-2:-1], own_position.shape[-1])
        if position.shape != everywhere:
            try:  # the same others for all agents
                position, velocity = (np.broadcast_to(part, everywhere) for part in (position, velocity))
            except ValueError as error:
                raise RangeError(
                    f"other poses have shape {position.shape[:-1]}, allowed: {(*lead, 'K')} as the desired input"
                ) from error
        motion = RelativeMotion.of(own_position, own_velocity, position, velocity)
        planes = self._half_planes(motion)
        flat = wish.reshape(-1, wish.shape[-1])  # a view: the array is a copy, in one piece
        desired_plane = flat[:, :2].copy()
        plane, braking = self._safe(desired_plane, motion, planes)
        if self.keep_right:
            self._pass_on_the_right(plane, braking, desired_plane, motion, planes)
        self.braking = braking.reshape(lead)
        self.least_barrier = planes.barriers.min(axis=1, initial=np.inf).reshape(lead)
        flat[:, :2] = plane
        return wish

    def filter_swarm(self, desired: ArrayLike, poses: Pose, getter: ClosestRobotGetter) -> Array:
        """Return safe inputs of all agents, each filtered against the agents near it.

        Args:
            desired: Desired inputs, shape (N, 2) or (N, 3).
            poses: Positions (m) and velocities (m/s), shape (N, 3).
            getter: Finds the neighbors of each agent.
        """
        return self.filter(desired, poses, getter.gathered(poses))

    def _pass_on_the_right(
        self, plane: Array, braking: NDArray[np.bool_], desired: Array, motion: RelativeMotion, planes: HalfPlanes
    ) -> None:
        """Redirect to the right, in place, what others take away of an input; inputs of braking agents stay."""
        limit = self.limit
        lost = np.minimum(np.maximum(desired, -limit), limit) - plane
        held = (~braking & (np.hypot(lost[:, 0], lost[:, 1]) > _MIN_LOSS * limit)).nonzero()[0]
        if held.size:
            aside = plane[held]
            aside[:, 0] += self.keep_right * lost[held, 1]
            aside[:, 1] -= self.keep_right * lost[held, 0]
            plane[held] = self._safe(aside, motion.of_some(held), planes.of_some(held))[0]

    @property
    @abstractmethod
    def limit(self) -> float:
        """Largest input along x and along y."""

    @property
    @abstractmethod
    def _needs_velocity(self) -> bool: ...

    @abstractmethod
    def _half_planes(self, motion: RelativeMotion) -> HalfPlanes:
        """Return the inputs that keep each barrier."""

    @abstractmethod
    def _safe(self, desired: Array, motion: RelativeMotion, planes: HalfPlanes) -> tuple[Array, NDArray[np.bool_]]:
        """Return inputs (N, 2), and whether each agent brakes (N,).

        Args:
            desired: Desired inputs, shape (N, 2).
            motion: Of the agents, relative to those near them.
            planes: Inputs that keep the barriers.
        """

    def _known(self, what: str, pose: Pose, lead: tuple[int, ...] | None) -> tuple[Array, Array]:
        """Return position and velocity, shape (..., 3); without a velocity that is needed there is an error."""
        if pose.position is None:
            raise RangeError(f"safety filter: {what}: there is no position")
        position = np.asarray(pose.position, dtype=np.float64)
        if lead is not None and position.shape[:-1] != lead:
            raise RangeError(f"safety filter: {what}: shape is {position.shape[:-1]}, allowed: {lead} as desired")
        if pose.velocity is None:
            if self._needs_velocity:
                raise RangeError(f"safety filter: {what}: there is no velocity")
            return position, np.zeros_like(position)
        velocity = np.asarray(pose.velocity, dtype=np.float64)
        if velocity.shape != position.shape:
            raise RangeError(f"safety filter: {what}: velocity has shape {velocity.shape}, allowed: {position.shape}")
        return position, velocity


def positive(what: str, value: float, unit: str) -> float:
    """Return the value.

    Raises:
        RangeError: If it is not a number above zero.
    """
    if not 0.0 < value < np.inf:
        raise RangeError(f"{what} is {value}, allowed: above 0 {unit}".rstrip())
    return float(value)


def unit(vectors: Array) -> Array:
    """Return vectors of length 1; of zero and infinite ones, zero."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where((length > 0.0) & np.isfinite(length), vectors / length, 0.0)
