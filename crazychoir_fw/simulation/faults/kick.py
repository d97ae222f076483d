"""The physics of a kick: an impulse at a point of a free body."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np


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
