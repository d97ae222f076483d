"""From points to references: what all trajectory handlers share (docs/reference/crazychoir.md#7.1)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.attitude import rotation_of_quaternion, rpy_of_rotation
from crazychoir_fw.common.checkpoint import Stateful
from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.common.messages import Pose, Reference, TrajectoryPoint
from crazychoir_fw.planning.curves import Polynomial, State
from crazychoir_fw.planning.headings import FixedHeading, Heading, PathHeading
from crazychoir_fw.planning.limits import LimitReport, Limits, fit_duration
from crazychoir_fw.planning.trajectory import Trajectory

Array = NDArray[np.float64]

NEAR = 0.3
"""How far a drone may be from its reference for a new curve to go on from there (m)."""

_LARGEST_STEP_BACK = 0.5  # [s], of a clock that is being set; more is another flight


class TrajectoryHandler(Stateful, ABC):
    """Turns points into a curve and says where on it a drone should be; a subclass says which curve.

    A message of one point is a go-to; several points are a path through all of them. Points have times from now and
    world positions. The curve begins where the drone should be at present, with that velocity and acceleration, so that
    references are smooth whenever a new message comes; a drone that is not near its reference, or had none, starts from
    its pose. A first point at time 0 is where the drone already is.

    After the end the last position is held. Time is whatever the caller's clock says: it may stand still, and where it
    goes back (a simulation was reset) the trajectory is forgotten.

    Attributes:
        kind: What references carry: "position", "acceleration" or "fullstate".
        trajectory: What is being followed or held, None before the first message.
        report: What the last curve that was planned asks for of the limits, None where there are none.
    """

    kind: ClassVar[str] = "fullstate"
    _is_timed = True  # otherwise times of points mean nothing

    def __init__(
        self,
        update_frequency: float = 100.0,
        input_topic: str | None = None,
        *,
        yaw: float | str = "hold",
        relative: bool = False,
        near: float = NEAR,
        limits: Limits | None = None,
        legacy: bool = False,
    ) -> None:
        """Make a handler without a trajectory.

        Args:
            update_frequency: How often `evaluate` is meant to be called (Hz).
            input_topic: Topic on which a controller takes the references; None is the name of the kind.
            yaw: "hold" keeps the present heading, "path" turns the nose where the drone flies, a number is it (rad).
            relative: Points are relative to where the curve begins.
            near: How far a drone may be from its reference for a new curve to go on from there (m).
            limits: Fly more slowly than the points say, as slowly as it takes to keep within; None flies as they say.
            legacy: Reproduce the original: paths mirrored through the start at its height, go-tos of splines from rest
                and always from the pose, only the last point of a message for degree 7, yaw 0.
        """
        if not 0.0 < update_frequency < np.inf:
            raise RangeError(f"{self}: update_frequency is {update_frequency}, allowed: above 0 Hz")
        if yaw not in ("hold", "path") and not (isinstance(yaw, int | float) and np.isfinite(yaw)):
            raise RangeError(f"{self}: yaw is {yaw!r}, allowed: 'hold', 'path' or a number (rad)")
        self.update_frequency = update_frequency
        self.input_topic = self.kind if input_topic is None else input_topic
        self.yaw = yaw
        self.relative = relative
        self.near = near
        self.limits = limits
        self.legacy = legacy
        self.report: LimitReport | None = None
        self.trajectory: Trajectory | None = None
        self._begin = 0.0
        self._now = -np.inf

    def __str__(self) -> str:
        return type(self).__name__

    @abstractmethod
    def plan(self, times: Array, states: Sequence[State]) -> Polynomial:
        """Return a curve from the first state through the others.

        Args:
            times: When each is reached (s), increasing from 0, shape (m,), m at least 2.
            states: As many; the first one is where the curve begins, velocity and acceleration included.
        """

    def set_trajectory(self, points: Sequence[TrajectoryPoint], pose: Pose, now: float) -> None:
        """Plan a curve that begins now.

        Args:
            points: Where to be when, in seconds from now; one is a go-to.
            pose: Of the drone, shapes (3,) and (4,); may be empty once there is a reference.
            now: Time (s).

        Raises:
            RangeError: If the points make no curve: no point, numbers that are not finite, times that do not increase.
                What was followed before stays.
            StateError: If the position of the drone is unknown.
        """
        self._check_clock(now)
        start, yaw = self._start(pose, now)
        times, states = self._states(points, start)
        curve, self.report = self._within_limits(times, states)
        self.trajectory = Trajectory(curve, self._heading(curve, yaw))
        self._begin = now

    def set_curve(self, curve: Polynomial | Trajectory, now: float) -> None:
        """Follow a ready curve from now on, as `fit_drawn` makes it; where it begins is the caller's care."""
        self._check_clock(now)
        if isinstance(curve, Polynomial):
            yaw = 0.0 if self.trajectory is None else self._full_reference(now).yaw
            curve = Trajectory(curve, self._heading(curve, float(yaw)))
        self.trajectory = curve
        self._begin = now

    def evaluate(self, now: float) -> Reference | None:
        """Return the reference at a time (s), or None before the first trajectory."""
        self._check_clock(now)
        return None if self.trajectory is None else self._output(self._full_reference(now))

    def is_active(self, now: float) -> bool:
        """Return whether a curve is being flown, its end included."""
        self._check_clock(now)
        return self.trajectory is not None and now - self._begin <= self.trajectory.duration

    def reset(self) -> None:
        """Forget the trajectory."""
        self.trajectory = None
        self._now = -np.inf

    def _within_limits(self, times: Array, states: Sequence[State]) -> tuple[Polynomial, LimitReport | None]:
        """Return the curve, flown as slowly as limits demand."""
        if self.limits is None:
            return self.plan(times, states), None

        def slower(factor: float) -> Polynomial:
            # the begin is a fact; what points ask for is slowed down like the rest
            return self.plan(times * factor, [states[0], *(state.slowed(factor) for state in states[1:])])

        curve, _, report = fit_duration(slower, self.limits)
        return curve, report

    def _output(self, reference: Reference) -> Reference:
        """Return the parts of a full reference that this kind carries."""
        return reference

    def _full_reference(self, now: float) -> Reference:
        return self.trajectory.reference(now - self._begin)

    def _check_clock(self, now: float) -> None:
        if now < self._now - _LARGEST_STEP_BACK:
            self.reset()
        self._now = now

    def _start(self, pose: Pose, now: float) -> tuple[State, float]:
        """Return where a new curve begins, and the yaw (rad) there."""
        position = None if pose.position is None else _three(pose.position, f"{self}: position of the drone")
        if self.trajectory is not None and not self.legacy:
            present = self._full_reference(now)
            if position is None or np.linalg.norm(position - present.position) <= self.near:
                state = State(present.position, present.velocity, present.acceleration, present.jerk)
                return state, float(present.yaw)
        if position is None:
            raise StateError(f"{self}: the position of the drone is not known yet")
        velocity = np.zeros(3) if pose.velocity is None else _three(pose.velocity, f"{self}: velocity of the drone")
        return State(position, velocity), _yaw_of(pose)

    def _states(self, points: Sequence[TrajectoryPoint], start: State) -> tuple[Array, list[State]]:
        """Return times (s) and states of the curve, the begin included."""
        if not points:
            raise RangeError(f"{self}: a trajectory without points")
        times, states = [0.0], [start]
        for number, point in enumerate(points):
            what = f"{self}: point {number}"
            time = float(point.time_s) if self._is_timed else number + 1.0
            if not (np.isfinite(time) and (time > times[-1] or (time == 0.0 and number == 0 and len(points) > 1))):
                raise RangeError(f"{what} is at {time:g} s, allowed: after {times[-1]:g} s")
            if time == 0.0:
                continue
            state = State(
                self._place(_three(point.position, f"{what}: position"), start.position, len(points) > 1),
                _three(point.velocity, f"{what}: velocity"),
                _three(point.acceleration, f"{what}: acceleration"),
                _three(point.jerk, f"{what}: jerk"),
            )
            times.append(time)
            states.append(state)
        return np.array(times), states

    def _place(self, position: Array, start: Array, is_path: bool) -> Array:
        """Return where a point lies in the world."""
        if self.legacy and is_path:
            return np.array([start[0] - position[0], start[1] - position[1], start[2]])
        return start + position if self.relative else position

    def _heading(self, curve: Polynomial, yaw: float) -> Heading:
        if self.legacy:
            return FixedHeading(0.0)
        if self.yaw == "path":
            return PathHeading(curve, yaw)
        return FixedHeading(yaw if self.yaw == "hold" else float(self.yaw))


def _three(values: ArrayLike, what: str) -> Array:
    vector = np.array(values, dtype=float)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise RangeError(f"{what} is {vector.tolist()}, allowed: three finite numbers")
    return vector


def _yaw_of(pose: Pose) -> float:
    """Return the yaw (rad) of a pose, 0 where it is not known."""
    if pose.orientation is None:
        return 0.0
    quaternion = np.asarray(pose.orientation, dtype=float)
    if quaternion.shape != (4,) or not np.isfinite(quaternion).all() or not quaternion.any():
        return 0.0
    return float(rpy_of_rotation(rotation_of_quaternion(quaternion))[2])
