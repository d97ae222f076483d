"""OpenGL of the machine: which shared libraries a way to draw needs, and how MuJoCo is imported without them."""

import ctypes
import importlib.util
import os
from collections.abc import Iterator
from contextlib import contextmanager

NEEDS = {
    "egl": (("libEGL.so.1",), ("libOpenGL.so.0", "libGL.so.1")),
    "osmesa": (("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"),),
}
"""Word of `MUJOCO_GL` to groups of shared libraries; one of each group must load."""
ALWAYS_IMPORTABLE = ("", "enable", "enabled", "on", "true", "1", "glfw", "glx", "cgl", "wgl")
"""Words of `MUJOCO_GL` with which MuJoCo imports no library that may be missing."""


def loads(*names: str) -> bool:
    """Return whether one of the shared libraries can be loaded."""
    for name in names:
        try:
            ctypes.CDLL(name)
        except OSError:
            continue
        return True
    return False


def has_libraries(way: str) -> bool:
    """Return whether the shared libraries of a way to draw are installed."""
    return all(loads(*names) for names in NEEDS[way])


@contextmanager
def importable() -> Iterator[None]:
    """Let `import mujoco` succeed within the block, whatever `MUJOCO_GL` names.

    MuJoCo raises while it is imported if the library that `MUJOCO_GL` names, or PyOpenGL, is missing. This package
    looks for a way to draw when it first draws, and says then in one sentence what is missing (`recording/opengl.py`).
    """
    word = os.environ.get("MUJOCO_GL", "")
    way = word.strip().lower()
    if way in ALWAYS_IMPORTABLE or (way in NEEDS and has_libraries(way) and importlib.util.find_spec("OpenGL")):
        yield
        return
    os.environ["MUJOCO_GL"] = "disable"
    try:
        yield
    finally:
        os.environ["MUJOCO_GL"] = word
