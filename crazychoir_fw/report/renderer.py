"""Pictures of a MuJoCo model without a screen.

Stands in for `mujoco.Renderer`, which has to know how to draw when `mujoco` is imported; `opengl` chooses later.
"""

from types import TracebackType

import mujoco
import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.report.opengl import create_context, is_software

_ADDED_GEOMS = 6000
"""Room for what `film` adds to a scene."""


class Renderer:
    """Draws one model; use it as a context manager, in one thread.

    Args:
        model: What to draw.
        width: Width of the pictures (pixels).
        height: Height of the pictures (pixels).

    Raises:
        RenderingError: If there is no OpenGL on this machine.
    """

    def __init__(self, model: mujoco.MjModel, width: int, height: int) -> None:
        self.width = width
        self.height = height
        self.option = mujoco.MjvOption()
        self.scene = mujoco.MjvScene(model, maxgeom=model.ngeom + _ADDED_GEOMS)
        self._model = model
        self._rectangle = mujoco.MjrRect(0, 0, width, height)
        self._gl = create_context(width, height)
        self._gl.make_current()
        self.drawer = self._create_drawer()
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self.drawer)

    def _create_drawer(self) -> mujoco.MjrContext:
        # a buffer larger than the picture would be cleared and resolved with every frame
        size, quality = self._model.vis.global_, self._model.vis.quality
        before = size.offwidth, size.offheight, quality.offsamples, quality.shadowsize
        size.offwidth, size.offheight = self.width, self.height
        if is_software():
            # a third of the time per picture, and hardly a difference to see
            quality.offsamples, quality.shadowsize = 0, min(quality.shadowsize, 1024)
        try:
            return mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_100)
        finally:
            size.offwidth, size.offheight, quality.offsamples, quality.shadowsize = before

    def __enter__(self) -> "Renderer":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def update(self, data: mujoco.MjData, camera: mujoco.MjvCamera) -> None:
        """Fill `scene` with what *camera* sees of *data*; the scene may be changed before `draw`."""
        everything = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(self._model, data, self.option, None, camera, everything, self.scene)

    def draw(self) -> NDArray[np.uint8]:
        """Return the picture of `scene`, shape (height, width, 3), first row on top."""
        picture = np.empty((self.height, self.width, 3), dtype=np.uint8)
        self._gl.make_current()
        mujoco.mjr_render(self._rectangle, self.scene, self.drawer)
        mujoco.mjr_readPixels(picture, None, self._rectangle, self.drawer)
        return picture[::-1]

    def close(self) -> None:
        """Free what the graphics driver holds. May be called twice."""
        if self._gl is not None:
            self._gl.make_current()
            self.drawer.free()
            self._gl.free()
            self._gl = None
