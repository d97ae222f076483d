"""Which camera a film or a picture is shot with: one word, and what it means for each frame.

The camera `follow` keeps the whole swarm in the picture and moves calmly. All positions are known before the first
frame is drawn, so its path is planned over the whole flight: center and radius of the swarm are averaged over a window
centered on each instant, which has no lag.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.recording.viewpoint import Viewpoint, chase, first_person

_WINDOW_S = 3.0  # averaging of center and radius
_MARGIN_M = 0.08  # around the outermost drones
_USED = np.array([0.86, 0.78])  # of half the width and half the height: title, names and bar are around it
_NEAREST_M = 1.1  # of the camera, from a lonely drone
_GIVEN_UP_M = 10.0  # distance at which a drone may be lost from sight, beyond three times the usual one
_AZIMUTH_DEG, _DRIFT_DEG_PER_S = 120.0, 2.5
_ELEVATION_DEG = -27.0
_ON_BOARD = {"fpv": 75.0, "chase": 45.0}  # [deg], vertical; a film shows more than a lens on board
_SHADOW_REACH_M = 2.5  # how far around a drone its own cameras see shadows

Shot = Callable[[mujoco.MjData, int], "mujoco.MjvCamera | Viewpoint"]
"""Where the camera is in a frame, from a state whose kinematics are up to date."""


@dataclass
class CameraPath:
    """Where a free camera looks at each of F instants."""

    center: NDArray[np.float64]  # (F, 3)
    """Point in the middle of the picture (m, world frame)."""

    distance: NDArray[np.float64]  # (F,)
    """Of the camera from there (m)."""

    radius: NDArray[np.float64]  # (F,)
    """How far drones are from there (m)."""

    azimuth_deg: NDArray[np.float64]  # (F,)
    """Heading of the view; MuJoCo's convention."""

    def place(self, camera: mujoco.MjvCamera, frame: int) -> None:
        """Set *camera* for one instant; becomes a free one."""
        camera.type = mujoco.mjtCamera.mjCAMERA_FREE
        camera.lookat[:] = self.center[frame]
        camera.distance = self.distance[frame]
        camera.azimuth = self.azimuth_deg[frame]
        camera.elevation = _ELEVATION_DEG


def follow(
    positions: NDArray[np.float64], times: NDArray[np.float64], *, fovy_deg: float = 45.0, aspect: float = 16.0 / 9.0
) -> CameraPath:
    """Plan a camera that follows a swarm as near as it can.

    Args:
        positions: Where the drones are (m, world frame), shape (F, N, 3); a drone whose position is NaN is left out.
        times: Instants of the frames (s of the film), shape (F,).
        fovy_deg: Angle between the lower and the upper edge of the picture (deg).
        aspect: Width of the picture over its height.

    Returns:
        The path; a drone that flies off alone is given up once it is far outside the others.
    """
    frames = len(times)
    step = float(times[-1] - times[0]) / (frames - 1) if frames > 1 else 1.0
    window = max(1, round(_WINDOW_S / step)) if step > 0.0 else 1
    kept = [_kept(points[np.isfinite(points).all(axis=-1)]) for points in positions]
    azimuth = _AZIMUTH_DEG + _DRIFT_DEG_PER_S * (times - times[0])
    upward = np.tan(np.radians(fovy_deg) / 2.0)
    slopes = np.array([upward * aspect, upward]) * _USED
    center = np.array([_center(*seen, slopes) for seen in zip(kept, azimuth, strict=True)])
    center = _average(center.reshape(frames, 3), window)
    distance, radius = np.zeros(frames), np.zeros(frames)
    for k, points in enumerate(kept):
        if len(points):
            away = points - center[k]
            radius[k] = np.linalg.norm(away, axis=1).max() + _MARGIN_M
            distance[k] = _least_distance(away, azimuth[k], slopes)
    distance = _average(_widest(np.maximum(distance, _NEAREST_M), window), window)
    return CameraPath(center, distance, _average(_widest(radius, window), window), azimuth)


def _kept(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the points without those that are given up."""
    if not len(points):
        return points
    away = np.linalg.norm(points - np.median(points, axis=0), axis=1)
    return points[away <= 3.0 * np.median(away) + _GIVEN_UP_M]


def _axes(azimuth_deg: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the axis of the view, shape (3,), and right and up in the picture, shape (2, 3)."""
    heading, tilt = np.radians(azimuth_deg), np.radians(_ELEVATION_DEG)
    forward = np.array([np.cos(tilt) * np.cos(heading), np.cos(tilt) * np.sin(heading), np.sin(tilt)])
    right = np.array([np.sin(heading), -np.cos(heading), 0.0])
    return forward, np.array([right, np.cross(right, forward)])


def _center(points: NDArray[np.float64], azimuth_deg: float, slopes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the point in the middle of the picture (m) from which a camera can be nearest to all points, (K, 3)."""
    if not len(points):
        return np.zeros(3)
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
    forward, across = _axes(azimuth_deg)
    away = points - middle
    sideward, depth = away @ across.T, (away @ forward)[:, None] * slopes
    # both edges of the picture touch a point then: what is near takes more of it
    shift = ((sideward - depth).max(axis=0) - (-sideward - depth).max(axis=0)) / 2.0
    return middle + shift @ across


def _least_distance(away: NDArray[np.float64], azimuth_deg: float, slopes: NDArray[np.float64]) -> float:
    """Return how far from the center a camera sees all points.

    Args:
        away: Points (m, from the center of the picture), shape (K, 3).
        azimuth_deg: Heading of the view.
        slopes: Of the edges of the picture against the axis of the view, right and up.
    """
    forward, across = _axes(azimuth_deg)
    beside = np.abs(away @ across.T) + _MARGIN_M
    return float((beside / slopes - (away @ forward)[:, None]).max())


def _average(values: NDArray[np.float64], window: int) -> NDArray[np.float64]:
    """Return a centered moving average along the first axis, applied twice; the ends are held."""
    half = window // 2
    for _ in range(2):
        edges = [(half, half)] + [(0, 0)] * (values.ndim - 1)
        total = np.cumsum(np.pad(values, edges, mode="edge"), axis=0)
        total = np.concatenate([np.zeros_like(total[:1]), total])
        values = (total[2 * half + 1 :] - total[: -2 * half - 1]) / (2 * half + 1)
    return values


def _widest(values: NDArray[np.float64], window: int) -> NDArray[np.float64]:
    """Return the running maximum over a centered window, so that the average never cuts a drone off."""
    half = window // 2
    padded = np.pad(values, half, mode="edge")
    return np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1).max(axis=-1)


def find_shot(model: mujoco.MjModel, word: str, path: CameraPath | None = None) -> Shot:
    """Return what a word for a camera means.

    Args:
        model: The world.
        word: ``follow`` for the whole swarm, ``fpv:NAME`` or ``chase:NAME`` with the name of a drone, else the name of
            a camera of the model.
        path: The path of ``follow``; None if it is only asked whether there is such a camera.

    Raises:
        ValueError: If there is no such camera or drone.
    """
    camera = mujoco.MjvCamera()
    if word == "follow":

        def keep_all(_: mujoco.MjData, frame: int) -> mujoco.MjvCamera:
            path.place(camera, frame)
            return camera

        return keep_all
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
    return path.center[frame], path.radius[frame]
