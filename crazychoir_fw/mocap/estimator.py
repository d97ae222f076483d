"""`Estimator`: velocities and angular velocities from the poses of motion capture (docs/reference/crazychoir.md#10)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.attitude import rotation_of_quaternion, rpy_of_rotation, wrapped
from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.mocap.predictor import LEGACY_STEP, TIME_CONSTANT, FilteredDerivative

Array = NDArray[np.float64]

_MIN_NORM = 0.8  # of a quaternion, docs/reference/crazychoir.md#10
_LARGEST_NORM = 1.25
_POSITION_MARGIN = 0.02  # [m], by which noise alone may move a pose
_ATTITUDE_MARGIN = 0.05  # [rad]
_RATES = ("body", "euler")


class Estimator:
    """Filters poses of one drone, shape (3,), or of several, shape (..., 3), which may be lost one by one.

    A sample is lost if it is not finite, if its quaternion is none (also all zeros, as occluded drones are published),
    if it is not newer than the one before, or if it jumps farther than a drone can fly. The last estimate, with its
    own time, then stays. A drone without a good sample for a while is lost; its next sample is a new beginning.

    As the `pose_callback` of a node: the node calls `set_pose` once with the pose that it keeps, and the estimator
    itself after each sample.
    """

    def __init__(
        self,
        *,
        rates: str = "body",
        time_constant: float = TIME_CONSTANT,
        max_speed: float = 10.0,
        max_rate: float = 35.0,
        lost_after: float = 0.25,
        legacy: bool = False,
    ) -> None:
        """Choose the filter.

        Args:
            rates: "body": angular velocity in the body; "euler": rates of the (unwrapped) roll, pitch and yaw.
            time_constant: Of the low-pass (s); the default is that of the original.
            max_speed: A sample that asks for more (m/s) is a jump.
            max_rate: A sample that asks for more (rad/s) is a jump.
            lost_after: Without a good sample for so long (s) a drone is lost.
            legacy: As the original: steps of 10 ms whatever the time stamps say, a history that begins with zeros,
                rates of Euler angles that are not unwrapped; lost is only what has no quaternion, and is replaced by
                the last sample.

        Raises:
            RangeError: If a number is outside its range.
            UnknownNameError: If there are no such rates.
        """
        if rates not in _RATES:
            raise UnknownNameError(f"rates is {rates!r}, allowed: {', '.join(_RATES)}")
        for name, value, least in (
            ("time_constant", time_constant, 0.0),
            ("max_speed", max_speed, 1e-3),
            ("max_rate", max_rate, 1e-3),
            ("lost_after", lost_after, 1e-3),
        ):
            if not (math.isfinite(value) and value >= least):
                raise RangeError(f"{name} is {value}, allowed: {least:g} or more")
        self.legacy = legacy
        self._rates = rates
        self._max_speed, self._max_rate, self._lost_after = max_speed, max_rate, lost_after
        self._velocity, self._angular = FilteredDerivative(time_constant), FilteredDerivative(time_constant)
        self._pose: Pose | None = None
        self.reset()

    # ---------------------------------------------------------------- samples

    def update(self, sample: Pose, now: float | None = None) -> Pose:
        """Take a sample.

        Args:
            sample: Position and orientation, shape (..., 3) and (..., 4), with the time when they were so; lost ones
                are NaN or zero.
            now: Time of the sample (s), if it has none.

        Returns:
            The estimate: all fields, and the time of the last good sample of all. Of one drone that was never seen all
            fields are None, of several those of that one are NaN.

        Raises:
            RangeError: If there is no time, or the number of drones changes.
        """
        position, orientation, time = self._arrays(sample, now)
        if self._newest is not None and not self.legacy and time < self._newest - self._lost_after:
            self.reset()  # simulated time began again
        if self._position is None:
            self._begin(len(position))
        self._newest = time if self._newest is None else max(time, self._newest)
        if self.legacy:
            self._update_legacy(position, orientation, time)
        else:
            self._update(position, orientation, time)
        return self.estimate

    def _arrays(self, sample: Pose, now: float | None) -> tuple[Array, Array, float]:
        time = sample.time if sample.time is not None else now
        if time is None or not math.isfinite(time):
            raise RangeError(f"time of the sample is {time}, allowed: seconds")
        position, orientation = np.asarray(sample.position, float), np.asarray(sample.orientation, float)
        shape = position.shape[:-1]
        if position.shape != (*shape, 3) or orientation.shape != (*shape, 4):
            raise RangeError(
                f"shapes of position and orientation are {position.shape} and {orientation.shape}, "
                "allowed: (..., 3) and (..., 4)"
            )
        if self._shape is not None and shape != self._shape:
            raise RangeError(f"shape of the drones is {shape}, allowed: {self._shape}, that of the first sample")
        self._shape = shape
        return position.reshape(-1, 3), orientation.reshape(-1, 4), float(time)

    def _begin(self, count: int) -> None:
        self._position = np.full((count, 3), 0.0 if self.legacy else np.nan)
        self._orientation = np.tile(_IDENTITY, (count, 1)) if self.legacy else np.full((count, 4), np.nan)
        self._angles = np.zeros((count, 3))
        self._times = np.full(count, -np.inf)
        self._velocity.begin((count, 3))
        self._angular.begin((count, 3))

    def _update(self, position: Array, orientation: Array, time: float) -> None:
        norm = np.sqrt(np.sum(orientation * orientation, axis=-1))
        good = np.isfinite(position).all(axis=-1) & (norm >= _MIN_NORM) & (norm <= _LARGEST_NORM)
        dt = time - self._times
        good &= dt > 0.0
        orientation = orientation / np.where(good, norm, 1.0)[:, None]

        fresh = good & (dt > self._lost_after)
        going = good & ~fresh
        step = np.where(going[:, None], position - self._position, 0.0)
        turn = np.where(going[:, None], _turn(self._orientation, orientation), 0.0)
        distance, angle = np.sqrt(np.sum(step * step, axis=-1)), np.sqrt(np.sum(turn * turn, axis=-1))
        passed = np.where(going, dt, 1.0)
        going &= distance <= _POSITION_MARGIN + self._max_speed * passed
        going &= angle <= _ATTITUDE_MARGIN + self._max_rate * passed
        if self._rates == "euler":
            angles = rpy_of_rotation(rotation_of_quaternion(np.where(good[:, None], orientation, _IDENTITY)))
            turn = wrapped(angles - self._angles)
            self._angles = np.where((going | fresh)[:, None], angles, self._angles)

        self._velocity.update(step, dt, going)
        self._angular.update(turn, dt, going)
        self._velocity.value[fresh] = 0.0
        self._angular.value[fresh] = 0.0
        self._keep(going | fresh, position, orientation, time)

    def _update_legacy(self, position: Array, orientation: Array, time: float) -> None:
        seen = np.sqrt(np.sum(orientation * orientation, axis=-1)) >= _MIN_NORM
        position = np.where(seen[:, None], position, self._position)
        orientation = np.where(seen[:, None], orientation, self._orientation)
        angles = rpy_of_rotation(rotation_of_quaternion(orientation))
        dt, everyone = np.full(len(position), LEGACY_STEP), np.ones(len(position), bool)
        self._velocity.update(position - self._position, dt, everyone)
        self._angular.update(angles - self._angles, dt, everyone)
        self._angles = angles
        self._position, self._orientation = position, orientation
        self._times = np.where(seen, time, self._times)

    def _keep(self, who: Array, position: Array, orientation: Array, time: float) -> None:
        self._position = np.where(who[:, None], position, self._position)
        self._orientation = np.where(who[:, None], orientation, self._orientation)
        self._times = np.where(who, time, self._times)

    # ---------------------------------------------------------------- what is known

    @property
    def estimate(self) -> Pose:
        """The estimate, as of the last good sample."""
        if self._position is None or (self._shape == () and self._times[0] == -np.inf):
            return Pose()
        shape, known = self._shape or (), np.isfinite(self._times)[:, None]
        return Pose(
            position=self._position.reshape(*shape, 3).copy(),
            orientation=self._orientation.reshape(*shape, 4).copy(),
            velocity=np.where(known, self._velocity.value, np.nan).reshape(*shape, 3),
            angular=np.where(known, self._angular.value, np.nan).reshape(*shape, 3),
            time=float(np.max(self._times)) if known.any() else None,
        )

    @property
    def is_lost(self) -> NDArray[np.bool_] | bool:
        """Which drones are lost as of the newest sample, shape (...); True before the first one."""
        return True if self._newest is None else self.is_lost_at(self._newest)

    def is_lost_at(self, now: float) -> NDArray[np.bool_] | bool:
        """Return which drones have no good sample within `lost_after` before a time (s): also if none came at all."""
        if self._position is None:
            return True
        lost = now - self._times > self._lost_after
        return bool(lost[0]) if self._shape == () else lost.reshape(self._shape or ())

    def reset(self) -> None:
        """Forget all samples."""
        self._shape: tuple[int, ...] | None = None
        self._position: Array | None = None
        self._orientation: Array = np.zeros((0, 4))
        self._angles: Array = np.zeros((0, 3))
        self._times: Array = np.zeros(0)
        self._newest: float | None = None

    # ---------------------------------------------------------------- as the callback of a node

    def set_pose(self, current_pose: Pose) -> None:
        """Take the pose of a node, whose velocities are to be filled in."""
        self._pose = current_pose

    def __call__(self) -> None:
        """Filter the pose of `set_pose`, in place, after each sample; the time stays that of the last good one.

        Raises:
            RangeError: If there is none, or it has no time.
        """
        if self._pose is None:
            raise RangeError("the estimator has no pose, allowed: one given to set_pose")
        estimate = self.update(self._pose)
        for name in ("position", "orientation", "velocity", "angular", "time"):
            setattr(self._pose, name, getattr(estimate, name))


_IDENTITY = np.array([0.0, 0.0, 0.0, 1.0])


def _turn(before: Array, after: Array) -> Array:
    """Return the rotation vectors (rad, body) from attitudes to others, shape (n, 3), the short way round."""
    a, b, c, w0 = before.T
    x, y, z, w1 = after.T
    v = np.array([w0 * x - w1 * a - b * z + c * y, w0 * y - w1 * b - c * x + a * z, w0 * z - w1 * c - a * y + b * x])
    w = w0 * w1 + a * x + b * y + c * z
    length = np.sqrt(np.sum(v * v, axis=0))
    angle = 2.0 * np.arctan2(length, np.abs(w))
    scale = np.where(length > 1e-12, angle / np.maximum(length, 1e-12), 2.0)
    return (v * np.copysign(scale, w)).T
