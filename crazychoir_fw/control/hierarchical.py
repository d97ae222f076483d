"""`HierarchicalController`: position, then attitude, then a command (docs/reference/crazychoir.md#4.2)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, Reference, Twist
from crazychoir_fw.control.controller import CrazyflieController, ReferenceHandler
from crazychoir_fw.control.periodic_timer import PeriodicTimer
from crazychoir_fw.control.position import DEFAULT_MASS, STANDARD_GRAVITY
from crazychoir_fw.control.senders import SenderStrategy
from crazychoir_fw.control.strategies import AttitudeCtrlStrategy, PositionCtrlStrategy

Array = NDArray[np.float64]

_SAME = 1e-5  # relative difference of two frequencies that are meant to be one

# Of staying in place by accelerations: slow enough for any attitude law, critically damped, and tilting little.
_STAY_K_P = 2.0  # [1/s^2]
_STAY_K_V = 2.8  # [1/s]
_STAY_LIMIT = 3.0  # [m/s^2], per axis


class HierarchicalController(CrazyflieController):
    """Runs a position law, an attitude law and a sender, each at its rate.

    With one frequency for all, one step does all. Otherwise the position law runs at its own, attitude and sender at
    theirs. Nothing is sent before position, velocity and attitude of the drone are known. As long as no reference came
    the drone keeps the position that it had at the first step, level, at yaw 0; afterwards the last reference is held.
    """

    commands = ("fpqr", "frpy")
    filtered = "acceleration"

    def __init__(
        self,
        pos_strategy: PositionCtrlStrategy | None = None,
        attitude_strategy: AttitudeCtrlStrategy | None = None,
        command_sender: SenderStrategy | None = None,
        traj_handler: ReferenceHandler | None = None,
        *,
        position_strategy: PositionCtrlStrategy | None = None,
    ) -> None:
        """Choose the parts.

        Args:
            pos_strategy: The position law; needed.
            attitude_strategy: The attitude law; None for senders that send the attitude itself.
            command_sender: What the command consists of; needed.
            traj_handler: Keeps the reference; None keeps it as it is given.
            position_strategy: Another name of `pos_strategy`.

        Raises:
            RangeError: If a part is missing, or attitude law and sender have different frequencies.
        """
        super().__init__(command_sender, traj_handler)
        who = type(self).__name__
        if (pos_strategy is None) == (position_strategy is None):
            given = "neither" if pos_strategy is None else "both"
            raise RangeError(f"{who}: {given} of pos_strategy and position_strategy is given, allowed: one of them")
        self.position_strategy: PositionCtrlStrategy = position_strategy if pos_strategy is None else pos_strategy  # type: ignore[assignment]
        self.attitude_strategy = attitude_strategy
        send_freq = self.command_sender.send_freq
        if attitude_strategy is not None and not _is_same(attitude_strategy.update_frequency, send_freq):
            raise RangeError(
                f"{who}: attitude_strategy runs at {attitude_strategy.update_frequency:g} Hz and command_sender at "
                f"{send_freq:g} Hz, allowed: the same frequency"
            )
        if attitude_strategy is None and self.command_sender.kind == "fpqr":
            raise RangeError(f"{who}: attitude_strategy is None, allowed with thrust and body rates: an attitude law")
        self._send_schedule = PeriodicTimer(send_freq)
        self._position_schedule: PeriodicTimer | None = None
        if not _is_same(self.position_strategy.update_frequency, send_freq):
            self._position_schedule = PeriodicTimer(self.position_strategy.update_frequency)

        mass = getattr(self.position_strategy, "mass", DEFAULT_MASS)
        gravity = getattr(self.position_strategy, "gravity", STANDARD_GRAVITY)
        self.thrust: Array = np.asarray(mass, float) * gravity
        """Thrust (N) that the position law wants, shape (...); hover at first."""
        self.desired_attitude: Array = np.eye(3)
        """Attitude that the position law wants, matrices from body to world, shape (..., 3, 3)."""
        self.desired_pqr: Array = np.zeros(3)
        """Body rates (rad/s) that the attitude law wants, shape (..., 3)."""
        self._frozen: Reference | None = None

    @classmethod
    def with_filter(cls) -> type[CrazyflieController]:
        """See `CrazyflieController`."""
        return SafeHierarchicalController if cls is HierarchicalController else cls

    @property
    def periods(self) -> tuple[float, ...]:
        """See `CrazyflieController`: of the position law, where it has its own, and of attitude and sender."""
        schedules = (self._position_schedule, self._send_schedule)
        return tuple(schedule.period for schedule in schedules if schedule is not None)

    def clear_reference(self) -> None:
        """Forget the reference: at the next step the drone stays where it is then, until the next reference."""
        super().clear_reference()
        self._frozen = None
        self.position_strategy.reset()
        if self.attitude_strategy is not None:
            self.attitude_strategy.reset()

    def step(self, now: float) -> Twist | None:
        """See `CrazyflieController`."""
        pose = self.current_pose
        if pose.position is None or pose.velocity is None or pose.orientation is None:
            return None
        sends = self._send_schedule.is_due(now)
        thinks = sends if self._position_schedule is None else self._position_schedule.is_due(now)
        if not (sends or thinks):
            return None
        reference = self._followed(pose)
        if thinks:
            self.thrust, self.desired_attitude = self._position_law(pose, reference)
        return self._send(pose, reference) if sends else None

    def _position_law(self, pose: Pose, reference: Reference) -> tuple[Array, Array]:
        return self.position_strategy.control(pose, reference)

    def _send(self, pose: Pose, reference: Reference) -> Twist:
        if self.attitude_strategy is not None:
            self.attitude_strategy.desired_rates = self.position_strategy.desired_rates
            self.desired_pqr = self.attitude_strategy.control(pose, self.desired_attitude, reference)
        command = self.command_sender.command_sender(self.thrust, self.desired_attitude, self.desired_pqr)
        return self.command_sender.twist(command)

    def _followed(self, pose: Pose) -> Reference:
        """Return the reference that came, or the place where the drone was when it was needed first."""
        reference = self.desired_reference
        if reference is not None:
            return reference
        if self._frozen is None:
            position = np.array(pose.position, float)
            zero = np.zeros_like(position)
            self._frozen = Reference(position=position, velocity=zero, acceleration=zero, yaw=0.0)
        if self.position_strategy.follows_position:
            return self._frozen
        pull = _STAY_K_P * (self._frozen.position - pose.position) - _STAY_K_V * np.asarray(pose.velocity)
        return replace(self._frozen, acceleration=np.clip(pull, -_STAY_LIMIT, _STAY_LIMIT))


class SafeHierarchicalController(HierarchicalController):
    """A `HierarchicalController` whose position law is given those nearby as a third argument.

    Laws: `SafeFlatnessPositionCtrl`, `SafeFlatnessAccelerationCtrl`, or your own with
    ``control(current_pose, desired_reference, closest)``.
    """

    closest: Pose | Mapping[int, Pose] | None = None
    """Poses of nearby drones: arrays of shape (..., K, 3), padded with nan, or poses by number for a single drone."""

    position_strategy: PositionCtrlStrategy

    def set_closest(self, closest: Pose | Mapping[int, Pose]) -> None:
        """Take those nearby, as `crazychoir_fw.control.safety.ClosestRobotGetter` finds them."""
        self.closest = closest

    def _position_law(self, pose: Pose, reference: Reference) -> tuple[Array, Array]:
        return self.position_strategy.control(pose, reference, self.closest)  # type: ignore[call-arg]


def _is_same(frequency: float, other: float) -> bool:
    return math.isclose(frequency, other, rel_tol=_SAME)
