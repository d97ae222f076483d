"""Pictures of the camera at the nose of a drone, as observations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.simulation import World

KINDS = ("image", "depth")
"""Colors, or distances."""

_LARGEST = 1024  # [pixels]


@dataclass(frozen=True)
class OnboardCamera:
    """A camera that goes with the drone; the policy sees its present picture with every action.

    It sees scenery and no drone. Each picture of each flight is drawn by itself, which takes longer than its flight.
    """

    width: int = 64
    """(pixels)."""
    height: int = 48
    """(pixels)."""
    kind: str = "image"
    """``image``: red, green and blue, 0 to 255; ``depth``: distances along the view (m)."""
    fov_deg: float | None = None
    """Angle between the lower and the upper edge (deg); None is that of `Drone.camera`."""
    tilt_deg: float = 0.0
    """How far it is tilted upward (deg), -90 looks straight down."""
    far_m: float = 10.0
    """Distances beyond count as this one (m)."""

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise RangeError(f"camera: kind is {self.kind!r}, allowed: {', '.join(KINDS)}")
        for side, pixels in (("width", self.width), ("height", self.height)):
            if not (isinstance(pixels, int) and 1 <= pixels <= _LARGEST):
                raise RangeError(f"camera: {side} is {pixels!r}, allowed: 1 to {_LARGEST} pixels")
        if not (np.isfinite(self.far_m) and self.far_m > 0.0):
            raise RangeError(f"camera: far_m is {self.far_m!r}, allowed: above 0 m")

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a picture."""
        return (self.height, self.width, 3) if self.kind == "image" else (self.height, self.width)

    @property
    def dtype(self) -> type[np.uint8 | np.float32]:
        """Type of its numbers."""
        return np.uint8 if self.kind == "image" else np.float32

    def mount(self, world: World) -> Callable[[], NDArray[Any]]:
        """Mount one on each drone of a world.

        Returns:
            What takes a picture with each, shape (N, height, width, 3), or (N, height, width) of depth.

        Raises:
            RangeError: If an angle is outside its range.
            RenderingError: If there is no OpenGL on this machine; raised with the first pictures.
        """
        for drone in world.drones:
            assert drone.cameras is not None
            drone.cameras.sees_room_only = True  # drones of other flights are not there
        mounted = [
            drone.camera("fpv", self.width, self.height, fov_deg=self.fov_deg, tilt_deg=self.tilt_deg)
            for drone in world.drones
        ]
        if self.kind == "image":
            return lambda: np.stack([camera.image() for camera in mounted])
        return lambda: np.stack([np.minimum(camera.depth(), np.float32(self.far_m)) for camera in mounted])
