"""Find a way to draw without a screen.

MuJoCo draws with OpenGL, and its own `Renderer` decides how when `mujoco` is imported: by the variable `MUJOCO_GL`, or
GLFW (a window) if that is unset, which fails on a machine without a screen. This module decides later, by trying:

1. `MUJOCO_GL`, if it names a way (`egl`, `osmesa`, `glfw`, `cgl`) or forbids drawing (`disable`, `off`, `false`, `0`);
2. else `PYOPENGL_PLATFORM`, for programs that draw with PyOpenGL, too, which cannot change its way once imported;
3. else on Linux EGL (GPU, or Mesa in software), then OSMesa (software), then GLFW if there is a screen; CGL on macOS.

Libraries are tried with plain `dlopen` first, so that a missing one makes no noise. PyOpenGL is not needed.
On Debian, EGL in software needs `libegl1` and `libgl1`, OSMesa needs `libosmesa6`.
"""

import functools
import importlib
import os
import sys
from typing import Any

import mujoco

from crazychoir_fw.common.opengl_libraries import has_libraries
from crazychoir_fw.recording.gl_contexts import EglContext, OsmesaContext, opens_display, renderer_name

__all__ = ["RenderingError", "create_context", "rendering_available"]

_OFF = ("disable", "disabled", "off", "false", "0")
_WAYS = ("egl", "osmesa", "glfw", "glx", "cgl")
_UNSPECIFIC = ("", "enable", "enabled", "on", "true", "1")
_OURS: dict[str, Any] = {"egl": EglContext, "osmesa": OsmesaContext}
"""Contexts in place of MuJoCo's, which need PyOpenGL."""


class RenderingError(RuntimeError):
    """There is no OpenGL on this machine; the message says what was tried."""


def _missing(backend: str) -> str | None:
    """Return what keeps *backend* from working, None if nothing obvious does."""
    if backend == "egl":
        if not has_libraries("egl"):
            return "egl: libEGL or libGL is not installed (Debian: apt install libegl1 libgl1)"
        if not opens_display():
            return "egl: no device without a screen (Debian: apt install libegl-mesa0 libgl1-mesa-dri)"
    if backend == "osmesa" and not has_libraries("osmesa"):
        return "osmesa: libOSMesa is not installed (Debian: apt install libosmesa6)"
    if backend == "glfw" and sys.platform == "linux" and not _screen():
        return "glfw: there is no screen"
    return None


def _screen() -> bool:
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _candidates() -> list[str]:
    """Return the ways to try, best first.

    Raises:
        RenderingError: If `MUJOCO_GL` forbids drawing, or names no way to draw.
    """
    wish = os.environ.get("MUJOCO_GL", "").strip().lower()
    if wish in _OFF:
        raise RenderingError(f"no rendering: MUJOCO_GL={wish}")
    if wish not in _UNSPECIFIC:
        if wish not in _WAYS:
            raise RenderingError(f"no rendering: MUJOCO_GL is {wish}, allowed: {', '.join(_WAYS)}, or unset")
        return ["glfw" if wish == "glx" else wish]
    taken = os.environ.get("PYOPENGL_PLATFORM", "").strip().lower()
    if taken in ("egl", "osmesa"):
        return [taken]
    if sys.platform == "linux":
        return ["egl", "osmesa", "glfw"]
    return ["cgl" if sys.platform == "darwin" else "glfw"]


@functools.cache
def _context_class() -> Any:
    """Return the context class of the first way that works.

    Raises:
        RenderingError: If none does.
    """
    os.environ.setdefault("EGL_LOG_LEVEL", "fatal")  # Mesa warns on stderr about each driver that it skips
    reasons = []
    for backend in _candidates():
        try:
            if reason := _missing(backend):
                reasons.append(reason)
                continue
            context_class = _OURS.get(backend) or importlib.import_module(f"mujoco.{backend}").GLContext
            _draw_nothing(context_class)
        except Exception as error:  # drivers raise what they like
            reasons.append(f"{backend}: {' '.join(str(error).split()) or type(error).__name__}")
            continue
        return context_class
    raise RenderingError(f"no rendering: {'; '.join(reasons)}")


def _draw_nothing(context_class: Any) -> None:
    """Draw an empty model once, so that what fails does so here."""
    context = context_class(16, 16)
    try:
        context.make_current()
        model = mujoco.MjSpec().compile()
        model.vis.quality.offsamples = model.vis.quality.shadowsize = 0
        model.vis.global_.offwidth = model.vis.global_.offheight = 16
        mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100).free()
    finally:
        context.free()


def create_context(width: int, height: int) -> Any:
    """Return a new OpenGL context with `make_current()` and `free()`.

    Args:
        width: Width of the pictures (pixels).
        height: Height of the pictures (pixels).

    Raises:
        RenderingError: If there is no OpenGL on this machine.
    """
    return _context_class()(width, height)


def rendering_available() -> str | None:
    """Return None if pictures can be drawn here, else one line that says why not. Prints nothing, never raises."""
    try:
        _context_class()
    except RenderingError as error:
        return str(error)
    return None


def is_software() -> bool:
    """Return whether the processor draws, in place of a graphics card. A context must be current."""
    name = renderer_name().lower()
    return any(word in name for word in ("llvmpipe", "softpipe", "swrast", "software"))
