"""Cameras that look at a world while it runs: on board, behind a drone, or in the room.

A camera draws when it is asked to. All cameras of a world share one OpenGL context and one renderer, and a copy of what
moves, so that looking changes nothing of what is seen.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable
from math import gcd, isfinite
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError, StateError, UnknownNameError
from crazychoir_fw.common.ticks import TICKS_PER_SECOND

if TYPE_CHECKING:
    from crazychoir_fw.recording.likeness import Likeness
    from crazychoir_fw.recording.renderer import Renderer
    from crazychoir_fw.recording.viewpoint import Viewpoint
    from crazychoir_fw.simulation.event_scheduler import EventScheduler

FPV_SIZE = (324, 244)
"""Width and height of an onboard picture (pixels), as the camera of the AI deck gives them."""
FPV_FOV_DEG = 55.0
"""Vertical field of view of the onboard camera (deg): a lens like the AI deck's. The exact figure was not found."""
CHASE_SIZE = (640, 360)
_CHASE_FOV_DEG = 45.0
_LARGEST = 4096  # [pixels]

Look = Callable[[mujoco.MjData], "Viewpoint | mujoco.MjvCamera"]
"""Where a camera is, from a state whose kinematics are up to date."""


class Cameras:
    """What the cameras of one world share."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, agenda: EventScheduler, visuals: bool) -> None:
        self.agenda = agenda
        """Where pictures at a rate are appointed."""
        self._model = model
        self._data = data
        self._visuals = visuals
        self.sees_room_only = False
        """Whether pictures without drones are wanted from a world that was built with ``visuals=False``."""
        self._likeness: Likeness | None = None
        self._renderer: Renderer | None = None

    def on_board(
        self, drone_id: str, name: str, width: int | None, height: int | None, fov_deg: float | None, tilt_deg: float
    ) -> Camera:
        """Return a camera of a drone: ``fpv``, ``chase``, or one that stands in the model (see `Drone.camera`)."""
        from crazychoir_fw.recording.viewpoint import chase, first_person

        if not isfinite(tilt_deg) or abs(tilt_deg) > 90.0:
            raise RangeError(f"{drone_id}: tilt_deg is {tilt_deg}, allowed: -90 to 90")
        if name not in ("fpv", "chase"):
            own = f"{drone_id}/{name}"
            names = self._names()
            return self.in_room(own if own in names else name, width, height, fov_deg, also=["fpv", "chase"])
        body = int(self._model.body(drone_id).id)
        size, usual_fov = (FPV_SIZE, FPV_FOV_DEG) if name == "fpv" else (CHASE_SIZE, _CHASE_FOV_DEG)
        fov = usual_fov if fov_deg is None else _checked_fov(fov_deg)

        def look(data: mujoco.MjData) -> Viewpoint:
            rotation = data.xmat[body].reshape(3, 3)
            if name == "fpv":
                return first_person(data.xpos[body], rotation, fov, tilt_deg)
            return chase(data.xpos[body], rotation, fov)

        return Camera(self, f"{name}:{drone_id}", width or size[0], height or size[1], look)

    def in_room(
        self, name: str, width: int | None, height: int | None, fov_deg: float | None, also: list[str] | None = None
    ) -> Camera:
        """Return a camera that stands in the model."""
        names = self._names()
        if name not in names:
            known = ", ".join([*(also or []), *names]) or "none"
            raise UnknownNameError(f"no camera named '{name}', there are: {known}")
        number = names.index(name)
        fixed = mujoco.MjvCamera()
        fixed.type, fixed.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, number

        def look(data: mujoco.MjData) -> Viewpoint | mujoco.MjvCamera:
            if fov_deg is None:
                return fixed
            from crazychoir_fw.recording.viewpoint import Viewpoint

            _, up, backward = data.cam_xmat[number].reshape(3, 3).T
            return Viewpoint(data.cam_xpos[number].copy(), -backward, up, fov_deg)

        if fov_deg is not None:
            _checked_fov(fov_deg)
        return Camera(self, name, width or CHASE_SIZE[0], height or CHASE_SIZE[1], look)

    def anywhere(
        self, position: ArrayLike, look_at: ArrayLike, width: int | None, height: int | None, fov_deg: float | None
    ) -> Camera:
        """Return a camera that stands at one point and looks at another (m, world)."""
        from crazychoir_fw.recording.viewpoint import looking_at

        fov = float(self._model.vis.global_.fovy) if fov_deg is None else _checked_fov(fov_deg)
        try:
            view = looking_at(position, look_at, fov)
        except ValueError as error:
            raise RangeError(str(error)) from None
        return Camera(self, "fixed", width or CHASE_SIZE[0], height or CHASE_SIZE[1], lambda _: view)

    def _names(self) -> list[str]:
        model = self._model
        return [model.camera(k).name for k in range(model.ncam)]

    def expose(self, width: int, height: int, look: Look) -> Renderer:
        """Return the renderer with the present instant in its scene, seen from a camera.

        Raises:
            RenderingError: If there is no OpenGL on this machine.
            StateError: If the drones of the world cannot be seen.
        """
        from crazychoir_fw.recording.likeness import Likeness
        from crazychoir_fw.recording.renderer import Renderer

        if not (self._visuals or self.sees_room_only):
            raise StateError("the world was built with visuals=False, so that its drones cannot be seen")
        if self._renderer is None:
            self._renderer = Renderer(self._model, width, height)
            weakref.finalize(self, self._renderer.abandon).atexit = False
        self._renderer.resize(width, height)
        if self._likeness is None:
            self._likeness = Likeness(self._model)
        data = self._likeness.update(self._data)
        self._renderer.update(data, look(data))
        return self._renderer

    def close(self) -> None:
        """Free what the graphics driver holds; the next picture takes it again."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None


class Camera:
    """One camera; `World.camera` and `Drone.camera` make them. Use it in the thread that runs the world."""

    def __init__(self, cameras: Cameras, name: str, width: int, height: int, look: Look) -> None:
        for side, pixels in (("width", width), ("height", height)):
            if not (isinstance(pixels, int) and 1 <= pixels <= _LARGEST):
                raise RangeError(f"camera {name}: {side} is {pixels!r}, allowed: 1 to {_LARGEST} pixels")
        self.name = name
        self.width = width
        self.height = height
        self._cameras = cameras
        self._look = look

    def __repr__(self) -> str:
        return f"<Camera {self.name}, {self.width} x {self.height}>"

    def image(self) -> NDArray[np.uint8]:
        """Return what the camera sees now, red, green and blue, shape (height, width, 3), first row on top.

        Raises:
            RenderingError: If there is no OpenGL on this machine.
            StateError: If the world was built with ``visuals=False``.
        """
        return self._expose().draw()

    def depth(self) -> NDArray[np.float32]:
        """Return the distance of what it sees along the axis of the view (m), shape (height, width).

        Infinite where there is nothing but sky. Errors as `image`.
        """
        return self._expose().draw_depth()

    def segmentation(self) -> NDArray[np.int32]:
        """Return which geom is in each pixel, by its number in `World.model`, shape (height, width); -1 is sky.

        ``world.model.geom_bodyid`` tells the body. Errors as `image`.
        """
        return self._expose().draw_segmentation()

    def every(self, rate_hz: int, callback: Callable[[NDArray[np.uint8]], Any]) -> Callable[[], None]:
        """Take pictures while the world runs, at ticks that divide each simulated second as evenly as ticks can.

        Args:
            rate_hz: Pictures per simulated second, 1 to 1000.
            callback: Called with each picture.

        Returns:
            A function that ends it.

        Raises:
            RangeError: If the rate is no whole number from 1 to 1000.
        """
        if not (isinstance(rate_hz, int) and 1 <= rate_hz <= TICKS_PER_SECOND):
            raise RangeError(f"camera {self.name}: rate_hz is {rate_hz!r}, allowed: a whole number from 1 to 1000")
        together = gcd(rate_hz, TICKS_PER_SECOND)  # so many times a second the pattern begins again
        period, pictures = TICKS_PER_SECOND // together, rate_hz // together
        agenda = self._cameras.agenda
        cancels = [
            agenda.every(period, lambda: callback(self.image()), phase=k * TICKS_PER_SECOND // rate_hz)
            for k in range(pictures)
        ]

        def cancel() -> None:
            for one in cancels:
                one()

        return cancel

    def _expose(self) -> Renderer:
        return self._cameras.expose(self.width, self.height, self._look)


def _checked_fov(fov_deg: float) -> float:
    if not (isfinite(fov_deg) and 1.0 <= fov_deg <= 170.0):
        raise RangeError(f"fov_deg is {fov_deg}, allowed: 1 to 170")
    return float(fov_deg)
