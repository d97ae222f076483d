r"""Flatness laws whose horizontal acceleration passes a safety filter (docs/reference/crazychoir.md#4.3, #9).

The filter speaks of accelerations of the drone, the laws of forces of its rotors. Between them stand the mass and a
disturbance d that is estimated from how the velocity follows the force:

.. math:: m a = F - m g e_3 + m d

so that a drone keeps its velocity when the commanded acceleration is zero. The integral of the position error could not
do that: it would also integrate the error of a drone that the filter holds back.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.control.gains import PositionGains
from crazychoir_fw.control.position import (
    DEFAULT_MASS,
    STANDARD_GRAVITY,
    FlatnessAccelerationCtrl,
    FlatnessCtrl,
    FlatnessPositionCtrl,
)

Array = NDArray[np.float64]

_ALTERED = 1e-9  # [m/s^2]

# Of the estimate of the disturbance: two poles at -1.4/s, slower than the attitude follows and than the law works.
_OF_VELOCITY = 2.8  # [1/s]
_OF_DISTURBANCE = 2.0  # [1/s^2]


class AccelerationFilter(Protocol):
    """What the laws want of a filter; `crazychoir_fw.control.safety.DoubleIntegratorCBF` is one."""

    max_acceleration: float

    def filter(self, desired: ArrayLike, pose: Pose, others: Pose | Mapping[int, Pose]) -> Array:
        """Return the horizontal acceleration that is safe (m/s^2), shape (..., 2)."""


class SafeFlatnessCtrl(FlatnessCtrl):
    """What the safe laws share; put it before the law that it makes safe."""

    safety_filter: AccelerationFilter
    max_acceleration: float
    """Largest horizontal acceleration that the law asks for (m/s^2)."""
    closest: Pose | Mapping[int, Pose] | None = None
    altered: NDArray[np.bool_] = np.zeros((), bool)
    """Drones whose acceleration the filter changed in the last step, shape (...)."""

    def __init__(
        self,
        agent_id: int = 0,
        update_frequency: float = 100.0,
        safety_filter: AccelerationFilter | None = None,
        max_acceleration: float | None = None,
        vicon: bool = False,
        *,
        gains: str | PositionGains | None = None,
        mass: ArrayLike = DEFAULT_MASS,
        gravity: float = STANDARD_GRAVITY,
    ) -> None:
        """Choose filter, gains and vehicle.

        Args:
            agent_id: Number of the drone; nothing depends on it.
            update_frequency: How often `control` is called (Hz).
            safety_filter: Filter of accelerations; needed.
            max_acceleration: Largest horizontal acceleration that is asked for (m/s^2); None is that of the filter.
            vicon: Short for ``gains="vicon"``.
            gains: See `FlatnessCtrl`.
            mass: See `FlatnessCtrl`.
            gravity: See `FlatnessCtrl`.

        Raises:
            RangeError: If there is no filter of accelerations, or a number is outside its range.
            UnknownNameError: If there is no such gain set.
        """
        super().__init__(update_frequency, vicon, gains=gains, mass=mass, gravity=gravity)
        self.agent_id = agent_id
        self.make_safe(safety_filter, max_acceleration)

    def make_safe(self, safety_filter: AccelerationFilter | None, max_acceleration: float | None) -> None:
        """Take the filter; arguments and errors are those of the constructor."""
        who = type(self).__name__
        if not hasattr(safety_filter, "max_acceleration"):
            given = type(safety_filter).__name__
            raise RangeError(
                f"{who}: safety_filter is {given}, allowed: a filter of accelerations (DoubleIntegratorCBF)"
            )
        self.safety_filter = safety_filter  # type: ignore[assignment]
        limit = self.safety_filter.max_acceleration if max_acceleration is None else float(max_acceleration)
        if not 0.0 < limit < np.inf:
            raise RangeError(f"{who}: max_acceleration is {max_acceleration}, allowed: above 0 m/s^2")
        self.max_acceleration = limit

    def control(  # type: ignore[override]
        self,
        current_pose: Pose,
        desired_reference: Reference,
        closest: Pose | Mapping[int, Pose] | None = None,
    ) -> tuple[Array, Array]:
        """See `PositionCtrlStrategy`.

        Args:
            current_pose: Position, velocity and attitude, arrays of shape (..., 3) and (..., 4).
            desired_reference: What is to be followed.
            closest: Poses of nearby drones, see `SafeHierarchicalController`; None if there are none.
        """
        self.closest = {} if closest is None else closest
        made = super().control(current_pose, desired_reference)
        if self.desired_rates is not None and self.altered.any():
            # the attitude does not turn as that of the reference
            rates = self.desired_rates.copy()
            rates[self.altered, :2] = 0.0
            self.desired_rates = rates
        return made

    def force(self, current_pose: Pose, desired_reference: Reference) -> Array:
        """See `FlatnessCtrl`."""
        force = np.array(super().force(current_pose, desired_reference)) + np.zeros_like(current_pose.position)
        wish = ((force - self._weight) / self._mass)[..., :2]
        size = _length(wish)
        # straight ahead, also where it is too much: the filter would cut each axis by itself
        wish = wish * (self.max_acceleration / np.maximum(size, self.max_acceleration))
        others = _for_all(self.closest, wish.shape[:-1])
        safe = self.safety_filter.filter(wish, current_pose, others)
        self.altered = (np.abs(safe - wish) > _ALTERED).any(axis=-1)
        force[..., :2] = self._mass * self._against_disturbance(safe, current_pose)
        return force

    def _against_disturbance(self, acceleration: Array, pose: Pose) -> Array:
        """Return the specific force of the rotors that makes an acceleration (m/s^2), shape (..., 2)."""
        del pose
        return acceleration


def _length(vectors: Array) -> Array:
    """Return the lengths of vectors in the plane, shape (..., 1)."""
    x, y = vectors[..., 0], vectors[..., 1]
    return np.sqrt(x * x + y * y)[..., None]


def _for_all(closest: Any, lead: tuple[int, ...]) -> Pose | Mapping[int, Pose]:
    if lead and isinstance(closest, Mapping) and not closest:
        return Pose(position=np.full((*lead, 0, 3), np.nan), velocity=np.full((*lead, 0, 3), np.nan))
    return closest


class SafeFlatnessPositionCtrl(SafeFlatnessCtrl, FlatnessPositionCtrl):
    """Tracks position, velocity, acceleration and yaw as `FlatnessPositionCtrl`, as far as it is safe.

    Far from its place, because the filter kept it waiting, a drone flies back no faster than it can stop with
    `max_acceleration`. With gains that have an integral, an estimate of the disturbance takes its place in the plane,
    and is at most what the integral would be.
    """

    _velocity: Array | None = None  # [m/s], as it should be
    _push = 0.0  # [m/s^2], of the rotors, in the last period
    disturbance: Array | float = 0.0
    """Horizontal acceleration by what is not the rotors, as far as it is known (m/s^2), shape (..., 2)."""

    @cached_property
    def _reach(self) -> Array:
        """The horizontal error that counts at most (m), shape (..., 1)."""
        k_p, k_v = (np.asarray(k) / self._mass for k in (self._k_p, self._k_v))
        with np.errstate(divide="ignore", invalid="ignore"):
            # at this error it flies at a k_v / k_p towards its place, and stops within half of it
            reach = self.max_acceleration * np.nan_to_num((k_v / k_p)[..., :2], nan=np.inf, posinf=np.inf) ** 2
        return np.min(reach, axis=-1, keepdims=True)

    def force(self, current_pose: Pose, desired_reference: Reference) -> Array:
        """See `FlatnessCtrl`."""
        if desired_reference.position is not None:
            position = np.array(desired_reference.position, float)
            error = position - current_pose.position
            error[..., :2] *= np.minimum(self._reach / np.maximum(_length(error), 1e-9), 1.0)
            wanted = desired_reference
            desired_reference = Reference(
                current_pose.position + error,
                wanted.velocity,
                wanted.acceleration,
                wanted.jerk,
                wanted.yaw,
                wanted.yaw_rate,
            )
        return super().force(current_pose, desired_reference)

    def _integrated(self, error: Array) -> Array:
        return super()._integrated(error * np.array([0.0, 0.0, 1.0]))

    def _against_disturbance(self, acceleration: Array, pose: Pose) -> Array:
        if not self._has_integral:
            return acceleration
        measured = np.asarray(pose.velocity)[..., :2]
        if self._velocity is None or self._velocity.shape != measured.shape:
            self._velocity, self.disturbance, self._push = measured, np.zeros_like(measured), 0.0
        dt, error = 1.0 / self.update_frequency, measured - self._velocity
        self._velocity = self._velocity + dt * (self._push + self.disturbance + _OF_VELOCITY * error)
        limit = (self._k_i / self._mass)[..., :2] * self.gains.integral_limit
        self.disturbance = np.clip(self.disturbance + dt * _OF_DISTURBANCE * error, -limit, limit)
        self._push = acceleration - self.disturbance
        return self._push

    def reset(self) -> None:
        """Forget integral and disturbance."""
        super().reset()
        self._velocity = None


class SafeFlatnessAccelerationCtrl(SafeFlatnessCtrl, FlatnessAccelerationCtrl):
    """Makes an acceleration as `FlatnessAccelerationCtrl`, as far as it is safe."""


FlatnessPositionCtrl.filtered = SafeFlatnessPositionCtrl
FlatnessAccelerationCtrl.filtered = SafeFlatnessAccelerationCtrl
