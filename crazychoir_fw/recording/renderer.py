"""Pictures of a MuJoCo model without a screen.

Stands in for `mujoco.Renderer`, which has to know how to draw when `mujoco` is imported; `opengl` chooses later.
"""

import atexit
import itertools
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import TracebackType

import mujoco
import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.recording.opengl import create_context, is_software
from crazychoir_fw.recording.viewpoint import Viewpoint

_ADDED_GEOMS = 6000
"""Room for what `film` adds to a scene."""
_FLAG = mujoco.mjtRndFlag
_LIGHT = (_FLAG.mjRND_SHADOW, _FLAG.mjRND_REFLECTION, _FLAG.mjRND_SKYBOX, _FLAG.mjRND_FOG, _FLAG.mjRND_HAZE)

_open: "set[Renderer]" = set()
"""All that hold something of the graphics driver."""


def in_picture(scene: mujoco.MjvScene, points: NDArray[np.float64], width: int, height: int) -> NDArray[np.float64]:
    """Return where points (m, world), shape (N, 3), are in a picture (pixels from its upper left corner), shape (N, 2).

    What is behind the camera or outside of the picture is NaN.
    """
    eye = scene.camera[0]
    pos = (eye.pos + scene.camera[1].pos) / 2.0
    right = np.cross(eye.forward, eye.up)
    away = points - pos
    depth = away @ eye.forward
    scale = eye.frustum_near * height / (eye.frustum_top - eye.frustum_bottom)
    with np.errstate(divide="ignore", invalid="ignore"):
        x = width / 2.0 + scale * (away @ right) / depth
        y = height / 2.0 - scale * (away @ eye.up) / depth
    places = np.column_stack([x, y])
    seen = (depth > eye.frustum_near) & (x >= 0.0) & (x < width) & (y >= 0.0) & (y < height)
    places[~seen] = np.nan
    return places


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
        _close_all(lambda renderer: renderer._is_abandoned)
        self._is_abandoned = False
        self._thread = threading.current_thread()
        self._model = model
        self._free = mujoco.MjvCamera()
        self._rectangle = mujoco.MjrRect(0, 0, width, height)
        self._gl = create_context(width, height)
        self._gl.make_current()
        self.drawer = self._create_drawer()
        _open.add(self)
        self.drawer.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
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

    def resize(self, width: int, height: int) -> None:
        """Draw pictures of another size (pixels) from now on; a quarter of a millisecond, nothing if it is the same."""
        if (width, height) == (self.width, self.height):
            return
        self._gl.make_current()
        mujoco.mjr_resizeOffscreen(width, height, self.drawer)
        self.width, self.height = width, height
        self._rectangle = mujoco.MjrRect(0, 0, width, height)

    def update(self, data: mujoco.MjData, camera: mujoco.MjvCamera | Viewpoint) -> None:
        """Fill `scene` with what *camera* sees of *data*; the scene may be changed before `draw`."""
        everything = mujoco.mjtCatBit.mjCAT_ALL
        if isinstance(camera, Viewpoint):
            camera.aim(self._free)
            mujoco.mjv_updateScene(self._model, data, self.option, None, self._free, everything, self.scene)
            camera.settle(self.scene)
        else:
            mujoco.mjv_updateScene(self._model, data, self.option, None, camera, everything, self.scene)

    def draw(self) -> NDArray[np.uint8]:
        """Return the picture of `scene`, shape (height, width, 3), first row on top."""
        picture = np.empty((self.height, self.width, 3), dtype=np.uint8)
        self._gl.make_current()
        mujoco.mjr_render(self._rectangle, self.scene, self.drawer)
        mujoco.mjr_readPixels(picture, None, self._rectangle, self.drawer)
        return picture[::-1]

    def draw_depth(self) -> NDArray[np.float32]:
        """Return how far things are along the axis of the view (m), shape (height, width); infinite for the sky."""
        depth = np.empty((self.height, self.width), dtype=np.float32)
        with self._flags():
            mujoco.mjr_render(self._rectangle, self.scene, self.drawer)
            mujoco.mjr_readPixels(None, depth, self._rectangle, self.drawer)
        near, far = self.scene.camera[0].frustum_near, self.scene.camera[0].frustum_far
        with np.errstate(divide="ignore"):
            # the buffer counts from 1 at the near plane to 0 at the far one, which keeps digits in the distance
            meters = near * far / (near + depth[::-1].astype(np.float64) * (far - near))
        return np.where(depth[::-1] > 0.0, meters, np.inf).astype(np.float32)

    def draw_segmentation(self) -> NDArray[np.int32]:
        """Return the geom in each pixel by its number in the model, shape (height, width); -1 where there is none."""
        colors = np.empty((self.height, self.width, 3), dtype=np.uint8)
        with self._flags(_FLAG.mjRND_SEGMENT, _FLAG.mjRND_IDCOLOR):
            mujoco.mjr_render(self._rectangle, self.scene, self.drawer)
            mujoco.mjr_readPixels(colors, None, self._rectangle, self.drawer)
        number = colors[::-1].astype(np.int32) @ np.array([1, 256, 65536], dtype=np.int32)
        geoms = np.full(self.scene.ngeom + 2, -1, dtype=np.int32)
        for geom in itertools.islice(self.scene.geoms, self.scene.ngeom):
            if geom.objtype == mujoco.mjtObj.mjOBJ_GEOM and 0 <= geom.segid <= self.scene.ngeom:
                geoms[geom.segid + 1] = geom.objid
        return geoms[np.minimum(number, self.scene.ngeom + 1)]

    @contextmanager
    def _flags(self, *switched_on: mujoco.mjtRndFlag) -> Iterator[None]:
        """Draw without light and sky, which a measurement needs no time for."""
        before = self.scene.flags.copy()
        self._gl.make_current()
        try:
            self.scene.flags[list(map(int, _LIGHT))] = 0
            self.scene.flags[list(map(int, switched_on))] = 1
            yield
        finally:
            self.scene.flags[:] = before

    def close(self) -> None:
        """Free what the graphics driver holds. May be called twice."""
        if self._gl is not None:
            self._gl.make_current()
            self.drawer.free()
            self._gl.free()
            self._gl = None
            _open.discard(self)

    def abandon(self) -> None:
        """Have it closed when its thread begins the next one, or the process ends.

        For garbage collection, which comes in any thread, and between two commands to the driver for another picture.
        """
        self._is_abandoned = True


def _close_all(is_over: Callable[[Renderer], bool] = lambda _: True) -> None:
    """Close those of this thread, and of threads that have ended."""
    here = threading.current_thread()
    for renderer in list(_open):
        if is_over(renderer) and (renderer._thread is here or not renderer._thread.is_alive()):
            renderer.close()


# while OpenGL is still there
atexit.register(_close_all)
