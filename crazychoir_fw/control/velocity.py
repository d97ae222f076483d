"""Velocity law and `VelocityController`: position errors become a velocity (docs/reference/crazychoir.md#4.5)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.attitude import wrapped
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, Reference, Twist
from crazychoir_fw.control.controller import CrazyflieController, ReferenceHandler
from crazychoir_fw.control.gains import VELOCITY_GAINS, VelocityGains, chosen_gains
from crazychoir_fw.control.periodic_timer import PeriodicTimer, checked_frequency
from crazychoir_fw.control.senders import SenderStrategy

Array = NDArray[np.float64]


class VelocityCtrlStrategy:
    """Flies to a position by velocities: k_p (p_d - p) + k_v (v_d - v), and the reference's velocity in part.

    v_d is zero where the reference has none. Where it has a heading, the drone turns there, else at its yaw rate.
    """

    def __init__(self, update_frequency: float = 100.0, *, gains: str | VelocityGains | None = None) -> None:
        """Choose gains.

        Args:
            update_frequency: How often `control` is called (Hz).
            gains: ``webots`` (default), ``vicon``, ``mujoco`` or gains of your own.

        Raises:
            UnknownNameError: If there is no such gain set.
        """
        self.update_frequency = checked_frequency(type(self).__name__, "update_frequency", update_frequency)
        self.gains = chosen_gains(type(self).__name__, VELOCITY_GAINS, gains)
        self._k_p, self._k_v = np.array(self.gains.k_p), np.array(self.gains.k_v)

    def control(self, current_pose: Pose, desired_reference: Reference) -> Array:
        """Return velocity (m/s, world) and yaw rate (rad/s), shape (..., 4)."""
        wanted = np.zeros_like(current_pose.position, dtype=float)
        if desired_reference.velocity is not None:
            wanted = wanted + np.asarray(desired_reference.velocity)
        velocity = self.gains.feed_forward * wanted
        if desired_reference.position is not None:
            velocity = velocity + self._k_p * (np.asarray(desired_reference.position) - current_pose.position)
        if current_pose.velocity is not None:
            velocity = velocity + self._k_v * (wanted - current_pose.velocity)
        command = np.zeros((*velocity.shape[:-1], 4))
        command[..., :3] = velocity
        if desired_reference.yaw_rate is not None:
            command[..., 3] = desired_reference.yaw_rate
        if desired_reference.yaw is not None and current_pose.orientation is not None:
            R = current_pose.rotation
            error = wrapped(np.asarray(desired_reference.yaw) - np.arctan2(R[..., 1, 0], R[..., 0, 0]))
            command[..., 3] += self.gains.k_yaw * error
        return command


class VelocityController(CrazyflieController):
    """Runs a velocity law and a sender at the frequency of the law; without pose or reference it sends zero."""

    commands = ("vel",)
    filtered = "velocity"

    def __init__(
        self,
        velocity_strategy: VelocityCtrlStrategy | None = None,
        command_sender: SenderStrategy | None = None,
        traj_handler: ReferenceHandler | None = None,
    ) -> None:
        """Choose the parts.

        Args:
            velocity_strategy: The law; needed.
            command_sender: What the command consists of: needed, a velocity.
            traj_handler: Keeps the reference; None keeps it as it is given.

        Raises:
            RangeError: If a part is missing or of the wrong kind.
        """
        super().__init__(command_sender, traj_handler)
        who = type(self).__name__
        if velocity_strategy is None:
            raise RangeError(f"{who}: velocity_strategy is None, allowed: VelocityCtrlStrategy or your own")
        if self.command_sender.kind != "vel":
            raise RangeError(f"{who}: command_sender sends {self.command_sender.kind}, allowed: vel (VelSender)")
        self.velocity_strategy = velocity_strategy
        self._schedule = PeriodicTimer(velocity_strategy.update_frequency)

    @property
    def periods(self) -> tuple[float, ...]:
        """See `CrazyflieController`."""
        return (self._schedule.period,)

    def step(self, now: float) -> Twist | None:
        """See `CrazyflieController`."""
        if not self._schedule.is_due(now):
            return None
        reference, pose = self.desired_reference, self.current_pose
        if reference is None or pose.position is None:
            shape = () if pose.position is None else np.shape(pose.position)[:-1]
            velocity: Array = np.zeros((*shape, 4))
        else:
            velocity = self.velocity_strategy.control(pose, reference)
        return self.command_sender.twist(self.command_sender.command_sender(velocity))
