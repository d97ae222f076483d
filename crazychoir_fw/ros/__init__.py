"""ROS 2 nodes: thin adapters with the class names and keyword arguments of the paper around the plain layers.

This is the only package that imports rclpy. Install it with ``pip install 'crazychoir-fw[ros]'``, or source an
installation of ROS 2.
"""

import os
from importlib import import_module
from importlib.util import find_spec
from typing import Any

# drones of somebody else on the same network should not hear us: wider discovery is a choice
os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")

if find_spec("rclpy") is None:
    raise ImportError(
        "crazychoir_fw.ros needs rclpy, which is not installed: run pip install 'crazychoir-fw[ros]', "
        "or source an installation of ROS 2"
    )

# Looked up when they are asked for, so that a process imports what it uses.
_MODULE_OF = {
    "LayerNode": "crazychoir_fw.ros.node",
}

__all__ = sorted(_MODULE_OF)


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module 'crazychoir_fw.ros' has no attribute {name!r}")
    value = getattr(import_module(_MODULE_OF[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_MODULE_OF})
