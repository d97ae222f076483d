"""Where a camera stands and where it looks: on board of a drone, behind it, or anywhere in the room."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

NEAREST_M = 0.01
"""What is nearer than this is not seen: a drone's own deck is three times as far from the lens."""

# Over the front edge of the board, where the lens of an AI deck is. No data sheet says where exactly.
_LENS = np.array([0.032, 0.0, 0.014])
_UPWARD = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Viewpoint:
    """A camera with any attitude, the free cameras of MuJoCo cannot roll."""

    position: NDArray[np.float64]  # (3,)
    """Where the lens is (m, world frame)."""

    forward: NDArray[np.float64]  # (3,)
    """Direction of the view, a unit vector (world frame)."""

    up: NDArray[np.float64]  # (3,)
    """Direction of the upper edge of the picture, a unit vector at a right angle to `forward`."""

    fov_deg: float
    """Angle between the lower and the upper edge of the picture (deg)."""

    def aim(self, camera: mujoco.MjvCamera) -> None:
        """Set a free camera of MuJoCo to this place and direction; roll and field of view it cannot have."""
        camera.type = mujoco.mjtCamera.mjCAMERA_FREE
        camera.distance = 1.0
        camera.lookat[:] = self.position + self.forward
        camera.azimuth = np.degrees(np.arctan2(self.forward[1], self.forward[0]))
        camera.elevation = np.degrees(np.arcsin(np.clip(self.forward[2], -1.0, 1.0)))

    def settle(self, scene: mujoco.MjvScene) -> None:
        """Give a scene that was updated with the camera of `aim` this exact view."""
        for eye in scene.camera:
            eye.pos[:], eye.forward[:], eye.up[:] = self.position, self.forward, self.up
            eye.orthographic = 0
            eye.frustum_near = min(eye.frustum_near, NEAREST_M)
            eye.frustum_top = eye.frustum_near * np.tan(np.radians(self.fov_deg) / 2.0)
            eye.frustum_bottom = -eye.frustum_top
            eye.frustum_center = eye.frustum_width = 0.0  # 0: as wide as the picture


def looking_at(position: ArrayLike, target: ArrayLike, fov_deg: float) -> Viewpoint:
    """Return the view from one point (m, world frame) to another, the horizon level.

    Raises:
        ValueError: If the points are one, or not finite.
    """
    place, towards = np.array(position, dtype=float), np.array(target, dtype=float)
    if place.shape != (3,) or towards.shape != (3,) or not np.isfinite([place, towards]).all():
        raise ValueError(f"camera from {position} to {target}: allowed: two points (x, y, z) in m")
    distance = np.linalg.norm(towards - place)
    if distance < 1e-6:
        raise ValueError(f"camera at {position} looks at itself: allowed: two different points")
    return _level(place, (towards - place) / distance, fov_deg)


def first_person(
    position: NDArray[np.float64], rotation: NDArray[np.float64], fov_deg: float, tilt_deg: float = 0.0
) -> Viewpoint:
    """Return the view of a camera that is screwed to a drone.

    Args:
        position: Origin of the body (m, world frame), shape (3,).
        rotation: Attitude, body to world, shape (3, 3).
        fov_deg: Angle between the lower and the upper edge of the picture (deg).
        tilt_deg: Upward tilt of the camera against the body (deg).
    """
    tilt = np.radians(tilt_deg)
    forward = rotation @ np.array([np.cos(tilt), 0.0, np.sin(tilt)])
    up = rotation @ np.array([-np.sin(tilt), 0.0, np.cos(tilt)])
    return Viewpoint(position + rotation @ _LENS, forward, up, fov_deg)


def chase(
    position: NDArray[np.float64],
    rotation: NDArray[np.float64],
    fov_deg: float,
    behind_m: float = 0.55,
    above_m: float = 0.2,
) -> Viewpoint:
    """Return the view from behind a drone: follows its yaw, stays level when it rolls or pitches.

    Args:
        position: Origin of the body (m, world frame), shape (3,).
        rotation: Attitude, body to world, shape (3, 3).
        fov_deg: Angle between the lower and the upper edge of the picture (deg).
        behind_m: Horizontal distance from the drone (m).
        above_m: Height over the drone (m).
    """
    # of forward and up axis, the one whose shadow on the floor is longer says where the drone heads: in a steep climb
    # or dive the forward axis has none
    heading = rotation[:2, 0] if abs(rotation[2, 0]) < 0.9 else -np.sign(rotation[2, 0]) * rotation[:2, 2]
    length = np.linalg.norm(heading)
    heading = heading / length if length > 1e-9 else np.array([1.0, 0.0])
    place = position + np.array([*(-behind_m * heading), above_m])
    # a little over the drone, so that what lies ahead of it is in the middle of the picture
    towards = position + np.array([*(0.5 * behind_m * heading), 0.0])
    return looking_at(place, towards, fov_deg)


def _level(place: NDArray[np.float64], forward: NDArray[np.float64], fov_deg: float) -> Viewpoint:
    """Return a view without roll; straight up or down, north is on top."""
    right = np.cross(forward, _UPWARD)
    if np.linalg.norm(right) < 1e-9:
        right = np.array([1.0, 0.0, 0.0])
    right /= np.linalg.norm(right)
    return Viewpoint(place, forward, np.cross(right, forward), fov_deg)
