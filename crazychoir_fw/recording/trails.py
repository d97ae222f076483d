"""Fading lines behind the drones of a film."""

import itertools

import mujoco
import numpy as np
from numpy.typing import NDArray

_MAX_LINES = 5000  # in one scene, of all drones together
_MAX_PER_DRONE = 60
_WIDTH_PX = 2.5


class Trails:
    """Draws where drones have been.

    Args:
        positions: Path of each drone (m, world frame), shape (F, N, 3).
        colors: Color of each drone, shape (N, 3).
        length: How many frames a trail reaches back.
    """

    def __init__(self, positions: NDArray[np.float64], colors: NDArray[np.float64], length: int) -> None:
        self._positions = positions
        self._colors = np.column_stack([colors, np.ones(len(colors))]).astype(np.float32)
        drones = max(1, positions.shape[1])
        self._lines = min(length, _MAX_PER_DRONE, _MAX_LINES // drones)
        self._length = length

    def draw(self, scene: mujoco.MjvScene, frame: int) -> None:
        """Add the trails that end at *frame* to a scene."""
        # one grid for all frames, so that the bends of a trail stay where they are while it moves on
        if self._lines < 1:
            return
        stride = -(-self._length // self._lines)
        corners = [k for k in range(frame - frame % stride, max(-1, frame - self._length - 1), -stride)]
        corners = corners if corners and corners[0] == frame else [frame, *corners]
        for age, (new, old) in enumerate(itertools.pairwise(corners)):
            alpha = 0.9 * (1.0 - age / len(corners))
            for drone, color in enumerate(self._colors):
                self._line(scene, self._positions[new, drone], self._positions[old, drone], color, alpha)

    def _line(
        self,
        scene: mujoco.MjvScene,
        start: NDArray[np.float64],
        end: NDArray[np.float64],
        color: NDArray[np.float32],
        alpha: float,
    ) -> None:
        if scene.ngeom >= scene.maxgeom or not np.isfinite(start + end).all():
            return
        geom = scene.geoms[scene.ngeom]
        color[3] = alpha
        line = mujoco.mjtGeom.mjGEOM_LINE
        mujoco.mjv_initGeom(geom, line, np.zeros(3), np.zeros(3), np.zeros(9), color)
        mujoco.mjv_connector(geom, line, _WIDTH_PX, start, end)
        geom.category = mujoco.mjtCatBit.mjCAT_DECOR
        scene.ngeom += 1
