"""What is sent to a drone: thrust with body rates, thrust with angles, or a velocity.

docs/reference/crazychoir.md#5.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.attitude import rpy_of_rotation
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Twist
from crazychoir_fw.control.periodic_timer import checked_frequency

Array = NDArray[np.float64]


class SenderStrategy(ABC):
    """Turns what the laws say into the four numbers of a command, and those into a Twist."""

    kind: ClassVar[str]
    """What the numbers are: ``fpqr``, ``frpy`` or ``vel``."""

    def __init__(self, send_freq: float = 100.0) -> None:
        """Make a sender of so many commands per second."""
        self.send_freq = checked_frequency(type(self).__name__, "send_freq", send_freq)

    @abstractmethod
    def command_sender(self, *command: Any) -> Array:
        """Return the numbers of the command, shape (..., 4)."""

    def twist(self, u: Array) -> Twist:
        """Return the command as a Twist: thrust (N) in linear z, the rest in angular."""
        linear = np.zeros((*u.shape[:-1], 3))
        linear[..., 2] = u[..., 0]
        return Twist(linear, u[..., 1:].copy())  # in one piece, for it is read several times on its way


class FPQRSender(SenderStrategy):
    """Sends thrust (N) and body rates (rad/s)."""

    kind = "fpqr"

    def command_sender(self, thrust: ArrayLike, desired_attitude: Array, pqr: Array) -> Array:  # type: ignore[override]
        """Return f (N), p, q, r (rad/s), shape (..., 4)."""
        return _with_thrust(thrust, pqr)


class FRPYSender(SenderStrategy):
    """Sends thrust (N) and roll, pitch, yaw (rad), extrinsic x-y-z, of the desired attitude."""

    kind = "frpy"

    def command_sender(  # type: ignore[override]
        self, thrust: ArrayLike, desired_attitude: Array, pqr: Array | None = None
    ) -> Array:
        """Return f (N), roll, pitch, yaw (rad), shape (..., 4)."""
        return _with_thrust(thrust, rpy_of_rotation(desired_attitude))


class VelSender(SenderStrategy):
    """Sends a velocity (m/s, world) and a yaw rate (rad/s)."""

    kind = "vel"

    def __init__(
        self, send_freq: float = 100.0, *, max_speed: float | None = None, max_yaw_rate: float | None = None
    ) -> None:
        """Make a sender of so many commands per second.

        Args:
            send_freq: Commands per second.
            max_speed: Largest speed (m/s); what is faster keeps its direction. None is no limit.
            max_yaw_rate: Largest yaw rate (rad/s). None is no limit.

        Raises:
            RangeError: If a limit is not above 0.
        """
        super().__init__(send_freq)
        for name, limit in (("max_speed", max_speed), ("max_yaw_rate", max_yaw_rate)):
            if limit is not None and not limit > 0.0:
                raise RangeError(f"{type(self).__name__}: {name} is {limit}, allowed: above 0")
        self.max_speed = math.inf if max_speed is None else float(max_speed)
        self.max_yaw_rate = math.inf if max_yaw_rate is None else float(max_yaw_rate)

    def command_sender(self, velocity: ArrayLike) -> Array:  # type: ignore[override]
        """Return velocity (m/s, world) and yaw rate (rad/s), shape (..., 4).

        Args:
            velocity: The same, or the velocity alone, shape (..., 3).
        """
        given = np.asarray(velocity, float)
        u = np.zeros((*given.shape[:-1], 4))
        u[..., : given.shape[-1]] = given
        if self.max_speed < math.inf:
            speed = np.sqrt(np.sum(u[..., :3] ** 2, axis=-1, keepdims=True))
            u[..., :3] *= self.max_speed / np.maximum(speed, self.max_speed)
        if self.max_yaw_rate < math.inf:
            u[..., 3] = np.clip(u[..., 3], -self.max_yaw_rate, self.max_yaw_rate)
        return u

    def twist(self, u: Array) -> Twist:
        """Return the command as a Twist: velocity in linear, yaw rate in angular z."""
        angular = np.zeros((*u.shape[:-1], 3))
        angular[..., 2] = u[..., 3]
        return Twist(u[..., :3], angular)


def _with_thrust(thrust: ArrayLike, rest: Array) -> Array:
    thrust = np.asarray(thrust)
    shape = rest.shape[:-1] if rest.ndim > thrust.ndim else thrust.shape
    u = np.empty((*shape, 4))
    u[..., 0] = thrust
    u[..., 1:] = rest
    return u
