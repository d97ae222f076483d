"""A kick: an impulse at a point of the drone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import mujoco
import numpy as np

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.simulation.faults.fault import Fault
from crazychoir_fw.simulation.faults.rules import Vector, Word, ruled

if TYPE_CHECKING:
    from collections.abc import Sequence

    from crazychoir_fw.simulation.drone import Drone
    from crazychoir_fw.simulation.world import World


@dataclass(frozen=True, kw_only=True)
class Kick(Fault):
    """Somebody knocks against the drone: its velocity and its spin change at once."""

    kind: ClassVar[str] = "kick"
    is_instant: ClassVar[bool] = True

    impulse: tuple[float, float, float] = ruled(Vector(1.0, "N s"), (0.0, 0.0, 0.0))
    """Force times time (N s): 0.03 moves a Crazyflie of 30 g by 1 m/s."""

    point: tuple[float, float, float] = ruled(Vector(1.0, "m"), (0.0, 0.0, 0.0))
    """Where it hits (m, body frame); off the center of mass it also turns the drone."""

    frame: str = ruled(Word(("world", "body")), "world")
    """Frame of the impulse: ``world`` or ``body``."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not any(self.impulse):
            raise RangeError("kick: impulse is missing, allowed: one that is not zero")

    def begin(self, world: World, drone: Drone, seed: int) -> None:
        """Hit."""
        drone.uplink.dispatch("kick", list(map(float, self.impulse)), list(map(float, self.point)), self.frame)


def kick(
    model: mujoco.MjModel, data: mujoco.MjData, name: str, impulse: Sequence[float], point: Sequence[float], frame: str
) -> None:
    """Change the velocity of a free body as an impulse does.

    Args:
        model: The model.
        data: Its state; nothing but the velocity of the body changes.
        name: Name of the body.
        impulse: Force times time (N s), shape (3,).
        point: Where it acts (m, body frame), shape (3,).
        frame: Frame of the impulse: ``world`` or ``body``.
    """
    body = model.body(name)
    joint = int(body.jntadr[0])
    qpos, qvel = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
    to_world = _matrix(data.qpos[qpos + 3 : qpos + 7])
    to_body = _matrix(body.iquat)  # from the axes of the inertia
    in_body = np.asarray(impulse) if frame == "body" else to_world.T @ impulse

    spin = to_body @ ((to_body.T @ np.cross(np.asarray(point) - body.ipos, in_body)) / body.inertia)
    # the free joint tells the velocity of the origin of the body, which the center of mass need not be
    velocity = in_body / body.mass[0] - np.cross(spin, body.ipos)
    data.qvel[qvel : qvel + 3] += to_world @ velocity
    data.qvel[qvel + 3 : qvel + 6] += spin


def _matrix(quat_wxyz: np.ndarray) -> np.ndarray:
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, quat_wxyz / np.linalg.norm(quat_wxyz))
    return matrix.reshape(3, 3)
