"""Which camera a film or a picture is shot with: one word, and what it means for each frame."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.recording.camera import CameraPath
from crazychoir_fw.recording.viewpoint import Viewpoint, chase, first_person

_ON_BOARD = {"fpv": 75.0, "chase": 45.0}  # [deg], vertical; a film shows more than a lens on board
_SHADOW_REACH_M = 2.5  # how far around a drone its own cameras see shadows

Shot = Callable[[mujoco.MjData, int], "mujoco.MjvCamera | Viewpoint"]
"""Where the camera is in a frame, from a state whose kinematics are up to date."""


def find_shot(model: mujoco.MjModel, word: str, path: CameraPath | None = None, aspect: float = 1.0) -> Shot:
    """Return what a word for a camera means.

    Args:
        model: The world.
        word: ``follow`` for the whole swarm, ``fpv:NAME`` or ``chase:NAME`` with the name of a drone, else the name of
            a camera of the model.
        path: The path of ``follow``; None if it is only asked whether there is such a camera.
        aspect: Width of the picture over its height.

    Raises:
        ValueError: If there is no such camera or drone.
    """
    camera = mujoco.MjvCamera()
    if word == "follow":

        def follow(_: mujoco.MjData, frame: int) -> mujoco.MjvCamera:
            path.place(camera, frame, fovy_deg=model.vis.global_.fovy, aspect=aspect)
            return camera

        return follow
    kind, _, drone = word.partition(":")
    if kind in _ON_BOARD and drone:
        return _on_board(kind, find_drone(model, drone))
    names = [model.camera(k).name for k in range(model.ncam)]
    if word not in names:
        raise ValueError(f"no camera '{word}'; there are {', '.join(['follow', 'fpv:NAME', 'chase:NAME', *names])}")
    camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, names.index(word)
    return lambda data, frame: camera


def find_drone(model: mujoco.MjModel, name: str) -> int:
    """Return the number of the body of a drone.

    Raises:
        ValueError: If there is none of that name that flies freely.
    """
    free = model.jnt_bodyid[model.jnt_type == mujoco.mjtJoint.mjJNT_FREE]
    names = {model.body(int(body)).name: int(body) for body in free}
    if name not in names:
        known = ", ".join(list(names)[:8]) + (", …" if len(names) > 8 else "")
        raise ValueError(f"no drone '{name}' for the camera; there are {known}")
    return names[name]


def _on_board(kind: str, body: int) -> Shot:
    view = first_person if kind == "fpv" else chase

    def look(data: mujoco.MjData, _: int) -> Viewpoint:
        return view(data.xpos[body], data.xmat[body].reshape(3, 3), _ON_BOARD[kind])

    return look


def shadowed(view: mujoco.MjvCamera | Viewpoint, path: CameraPath, frame: int) -> tuple[NDArray[np.float64], float]:
    """Return center (m) and radius (m) of the part of the room whose shadows matter to a view."""
    if isinstance(view, Viewpoint):
        return view.position + view.forward, _SHADOW_REACH_M
    return path.center[frame], max(path.radius[frame], path.half_height[frame])
