"""OpenGL contexts without a screen, by the C interfaces of EGL and OSMesa.

MuJoCo's own contexts import PyOpenGL, which weighs 31 MB and is needed here for twenty functions. These have the same
three methods: `make_current()`, `free()`, and a constructor with width and height (pixels).
"""

import ctypes
import functools
import os
from collections.abc import Iterator
from typing import Any

__all__ = ["EglContext", "OsmesaContext", "opens_display", "renderer_name"]

_EGL_TRUE, _EGL_OPENGL_API, _EGL_PLATFORM_DEVICE = 1, 0x30A2, 0x313F
# colors of 8 bits, depth of 24, stencil of 8, drawn into a buffer of memory by OpenGL; the list ends with EGL_NONE
_EGL_SIZES = (0x3024, 8, 0x3023, 8, 0x3022, 8, 0x3021, 8, 0x3025, 24, 0x3026, 8)
_EGL_CONFIG = (*_EGL_SIZES, 0x3033, 0x0001, 0x3040, 0x0008, 0x3038)
_OSMESA_RGBA, _GL_FLOAT, _GL_RENDERER = 0x1908, 0x1406, 0x1F01
_MAX_DEVICES = 32


def _load(*names: str, mode: int = ctypes.DEFAULT_MODE) -> ctypes.CDLL:
    """Return the first of the shared libraries that loads.

    Raises:
        OSError: If none does.
    """
    for name in names[:-1]:
        try:
            return ctypes.CDLL(name, mode=mode)
        except OSError:
            continue
    return ctypes.CDLL(names[-1], mode=mode)


@functools.cache
def _egl() -> ctypes.CDLL:
    """Return EGL with the types of its functions; MuJoCo finds the functions of OpenGL in the library loaded beside."""
    _load("libOpenGL.so.0", "libGL.so.1", mode=ctypes.RTLD_GLOBAL)
    egl = _load("libEGL.so.1", mode=ctypes.RTLD_GLOBAL)
    pointer, number = ctypes.c_void_p, ctypes.c_uint
    for name, result, arguments in (
        ("eglGetProcAddress", pointer, [ctypes.c_char_p]),
        ("eglInitialize", number, [pointer] * 3),
        ("eglBindAPI", number, [number]),
        ("eglChooseConfig", number, [pointer, pointer, pointer, ctypes.c_int, pointer]),
        ("eglCreateContext", pointer, [pointer] * 4),
        ("eglMakeCurrent", number, [pointer] * 4),
        ("eglDestroyContext", number, [pointer] * 2),
        ("eglGetCurrentContext", pointer, []),
        ("eglReleaseThread", number, []),
    ):
        function = getattr(egl, name)
        function.restype, function.argtypes = result, arguments
    return egl


def _displays() -> Iterator[int]:
    """Yield the displays of the devices that need no screen; of `MUJOCO_EGL_DEVICE_ID` only, where it is set.

    Raises:
        RuntimeError: If it names no device.
    """
    egl = _egl()
    query = egl.eglGetProcAddress(b"eglQueryDevicesEXT")
    get_display = egl.eglGetProcAddress(b"eglGetPlatformDisplayEXT")
    if not query or not get_display:
        return
    devices, count = (ctypes.c_void_p * _MAX_DEVICES)(), ctypes.c_int(0)
    query = ctypes.CFUNCTYPE(ctypes.c_uint, ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)(query)
    if not query(_MAX_DEVICES, devices, ctypes.byref(count)):
        return
    get_display = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_uint, ctypes.c_void_p, ctypes.c_void_p)(get_display)
    found = list(devices[: count.value])
    if wish := os.environ.get("MUJOCO_EGL_DEVICE_ID"):
        if wish not in map(str, range(len(found))):
            raise RuntimeError(f"MUJOCO_EGL_DEVICE_ID is {wish}, allowed: 0 to {len(found) - 1}")
        found = [found[int(wish)]]
    for device in found:
        if display := get_display(_EGL_PLATFORM_DEVICE, device, None):
            yield display


@functools.cache
def _display() -> int | None:
    """Return the first display that opens; it stays open until the process ends, for all contexts."""
    return next((display for display in _displays() if _egl().eglInitialize(display, None, None) == _EGL_TRUE), None)


def opens_display() -> bool:
    """Return whether EGL finds a device, real or software, that needs no screen."""
    return _display() is not None


class EglContext:
    """A context of EGL that draws into buffers of its own.

    Raises:
        RuntimeError: If the driver makes none.
    """

    def __init__(self, width: int, height: int) -> None:
        egl, display = _egl(), _display()
        wanted, config, count = (ctypes.c_int * len(_EGL_CONFIG))(*_EGL_CONFIG), ctypes.c_void_p(), ctypes.c_int(0)
        egl.eglChooseConfig(display, wanted, ctypes.byref(config), 1, ctypes.byref(count))
        if not count.value:
            raise RuntimeError("the driver has no configuration with 8 bits of color and 24 of depth")
        egl.eglBindAPI(_EGL_OPENGL_API)
        self._context = egl.eglCreateContext(display, config, None, None)
        if not self._context:
            raise RuntimeError("the driver creates no context")

    def make_current(self) -> None:
        """Let this thread draw with the context.

        Raises:
            RuntimeError: If the driver refuses.
        """
        if _egl().eglMakeCurrent(_display(), None, None, self._context) != _EGL_TRUE:
            raise RuntimeError("the driver does not make the context current")

    def free(self) -> None:
        """Give the context back; further calls do nothing."""
        if self._context:
            if _egl().eglGetCurrentContext() == self._context:
                _egl().eglMakeCurrent(_display(), None, None, None)
                _egl().eglReleaseThread()
            _egl().eglDestroyContext(_display(), self._context)
        self._context = None


@functools.cache
def _osmesa() -> ctypes.CDLL:
    """Return OSMesa with the types of its functions."""
    osmesa = _load("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so", mode=ctypes.RTLD_GLOBAL)
    osmesa.OSMesaCreateContextExt.restype = ctypes.c_void_p
    osmesa.OSMesaCreateContextExt.argtypes = [ctypes.c_uint, *[ctypes.c_int] * 3, ctypes.c_void_p]
    osmesa.OSMesaMakeCurrent.restype = ctypes.c_ubyte
    osmesa.OSMesaMakeCurrent.argtypes = [ctypes.c_void_p] * 2 + [ctypes.c_uint, ctypes.c_int, ctypes.c_int]
    osmesa.OSMesaGetCurrentContext.restype = ctypes.c_void_p
    osmesa.OSMesaDestroyContext.argtypes = [ctypes.c_void_p]
    return osmesa


class OsmesaContext:
    """A context of Mesa's software renderer, with a buffer in memory.

    Raises:
        RuntimeError: If there is no memory for it.
    """

    def __init__(self, width: int, height: int) -> None:
        self._context = _osmesa().OSMesaCreateContextExt(_OSMESA_RGBA, 24, 8, 0, None)
        if not self._context:
            raise RuntimeError("OSMesa creates no context")
        self._size = width, height
        self._buffer: Any = (ctypes.c_float * (width * height * 4))()

    def make_current(self) -> None:
        """Let this thread draw with the context.

        Raises:
            RuntimeError: If Mesa refuses.
        """
        if not _osmesa().OSMesaMakeCurrent(self._context, self._buffer, _GL_FLOAT, *self._size):
            raise RuntimeError("OSMesa does not make the context current")

    def free(self) -> None:
        """Give context and buffer back; further calls do nothing."""
        if self._context:
            if _osmesa().OSMesaGetCurrentContext() == self._context:
                _osmesa().OSMesaMakeCurrent(None, None, _GL_FLOAT, 0, 0)
            _osmesa().OSMesaDestroyContext(self._context)
        self._context = self._buffer = None


def renderer_name() -> str:
    """Return what the driver calls itself, an empty text if it does not say; a context must be current."""
    for name in ("libOpenGL.so.0", "libGL.so.1", "libOSMesa.so.8"):
        try:
            get_string = ctypes.CDLL(name).glGetString
        except (OSError, AttributeError):
            continue
        get_string.restype, get_string.argtypes = ctypes.c_char_p, [ctypes.c_uint]
        if said := get_string(_GL_RENDERER):
            return bytes(said).decode(errors="replace")
    return ""
