"""Objects that agents of one process hand to each other without bytes, such that none can change another's.

What comes out equals what `serialization` would give: the same types are allowed, arrays are read-only. Arrays are
copied unless they are read-only already; the creator of a read-only array must not write to it through another view.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from crazychoir_fw.common.errors import MessageError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.guidance.serialization import DEEPEST, DTYPES, MAX_DIMENSIONS, dumps


class SharedPose(Pose):
    """A pose that several agents hold: it refuses to be changed."""

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"{name} cannot be set: the pose of another agent is shared")


_SHARED = frozenset([type(None), bool, int, float, str, bytes, SharedPose])


def frozen_pose(pose: Pose) -> SharedPose:
    """Return an immutable pose."""
    shared = object.__new__(SharedPose)
    fields = shared.__dict__
    for name, value in pose.__dict__.items():
        if isinstance(value, np.ndarray) and value.flags.writeable:
            value = value.copy()
            value.flags.writeable = False
        fields[name] = value
    return shared


def frozen(obj: object) -> Any:
    """Return an immutable object that no other component holds.

    Raises:
        MessageError: If something in it may not be sent.
    """
    if type(obj) is Pose:
        return frozen_pose(obj)
    return _frozen(obj, DEEPEST)


def _frozen(obj: object, depth: int) -> Any:
    kind = type(obj)
    if kind in _SHARED:
        return obj
    if kind is np.ndarray and obj.dtype.name in DTYPES and obj.ndim <= MAX_DIMENSIONS:  # type: ignore[attr-defined]
        return _frozen_array(obj)  # type: ignore[arg-type]
    if depth == 0:
        raise MessageError(f"message is nested too deep, allowed: {DEEPEST} levels")
    if kind is list or kind is tuple:
        items = [_frozen(item, depth - 1) for item in obj]  # type: ignore[attr-defined]
        return items if kind is list else tuple(items)
    if kind is dict:
        dumps(dict.fromkeys(obj))  # type: ignore[call-overload]  # checks the keys
        return {key: _frozen(item, depth - 1) for key, item in obj.items()}  # type: ignore[attr-defined]
    if isinstance(obj, Pose):
        return frozen_pose(obj)
    if isinstance(obj, np.generic) and obj.dtype.name in DTYPES:
        return obj.item()
    dumps(obj)  # the error says what is allowed
    raise MessageError(f"message holds a {kind.__name__}, which may not be sent")


def _frozen_array(array: np.ndarray) -> np.ndarray:
    if not array.flags.writeable:
        return array
    copy = array.copy()
    copy.flags.writeable = False
    return copy


def handed_out(obj: Any) -> Any:
    """Return what one receiver may keep: lists and dictionaries are its own, the rest is shared."""
    kind = type(obj)
    if kind is list:
        return [handed_out(item) for item in obj]
    if kind is tuple:
        return tuple(handed_out(item) for item in obj)
    if kind is dict:
        return {key: handed_out(item) for key, item in obj.items()}
    return obj
