"""Signals of a log out of the samples of a flight, while it is in memory or out of a file.

A layout says what the fields of a row are, as plain data: stretches of the memory of drones (`world_layout`), or poses.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.attitude import rotation_of_quaternion, rpy_of_rotation

Array = NDArray[np.float64]
Column = Callable[[str], NDArray[Any]]
"""Returns a field of all samples, shape (T, ...)."""

EXTRA = "extra/"  # prefix of fields that are signals as they are

_WORD = 4  # [bytes]
_TURNED_AT_ONCE = 256  # rows, which a cache holds: three times as fast as all of them

_TRUE_POSE = ("sim.x", "sim.y", "sim.z")
_TRUE_VELOCITY = ("sim.vx", "sim.vy", "sim.vz")
_TRUE_RATES = ("sim.wx", "sim.wy", "sim.wz")
_TRUE_ATTITUDE = ("sim.roll", "sim.pitch", "sim.yaw")
POSE_FIELDS = ("position", "velocity", "orientation")


def signals_of(layout: Mapping[str, Any], column: Column) -> dict[str, NDArray[Any]]:
    """Return the signals of samples, (T, N) each.

    Args:
        layout: What the fields are: ``parts``, ``drones`` and ``qpos`` of a world, or ``poses``, names of groups of
            signals; and ``extra``, names of further signals.
        column: Their values.
    """
    if "parts" in layout:
        signals = {**_log_variables(layout, column), **_true_motion(layout, column)}
    else:
        signals = {}
        for group in layout["poses"]:
            signals |= motion_signals(group, *(column(f"{group}/{name}") for name in POSE_FIELDS))
    return signals | {name: column(EXTRA + name) for name in layout["extra"]}


def scenery_of(layout: Mapping[str, Any], column: Column) -> NDArray[np.float32] | None:
    """Return positions of what moves beside the drones, shape (T, any), or None if nothing does."""
    columns = layout.get("scenery")
    return column("qpos")[:, columns].astype(np.float32) if columns else None


def _log_variables(layout: Mapping[str, Any], column: Column) -> dict[str, NDArray[Any]]:
    """Return every log variable of a swarm."""
    found: dict[str, list[tuple[NDArray[np.intp], NDArray[Any]]]] = {}
    for k, part in enumerate(layout["parts"]):
        cells_of, numbers = _cells(column(f"part{k}")), np.array(part["numbers"], np.intp)
        for name, (place, kind) in part["places"].items():
            found.setdefault(name, []).append((numbers, cells_of(place, np.dtype(kind))))
    return {name: _joined(own, layout["drones"]) for name, own in found.items()}


def _cells(copies: NDArray[np.uint8]) -> Callable[[int, np.dtype], NDArray[Any]]:
    """Return what reads a variable out of copies of memory by place and type, shape (T, N).

    The copies, (T, N, bytes), are turned once, word by word: variable by variable, memory would be walked through as
    often as there are variables, which takes five times as long.
    """
    if copies.shape[2] % _WORD:  # of a version that copied no whole words
        return lambda place, dtype: np.ascontiguousarray(copies[:, :, place : place + dtype.itemsize]).view(dtype)[
            ..., 0
        ]
    source = copies.view(np.uint32)
    words = np.empty((source.shape[2], *source.shape[:2]), np.uint32)
    for begin in range(0, len(source), _TURNED_AT_ONCE):
        rows = slice(begin, begin + _TURNED_AT_ONCE)
        words[:, rows] = np.moveaxis(source[rows], 2, 0)

    def read(place: int, dtype: np.dtype) -> NDArray[Any]:
        first, skipped = divmod(place, _WORD)
        count = -(-(skipped + dtype.itemsize) // _WORD)
        if count == 1 and dtype.itemsize == _WORD:
            return words[first].view(dtype)
        if count == 1 and skipped % dtype.itemsize == 0 and _WORD % dtype.itemsize == 0:
            parts = words[first].view(dtype).reshape(*copies.shape[:2], -1)
            return np.ascontiguousarray(parts[..., skipped // dtype.itemsize])
        joined = words[first] if count == 1 else np.stack(list(words[first : first + count]), axis=-1)
        cells = joined.view(np.uint8).reshape(*copies.shape[:2], count * _WORD)[..., skipped : skipped + dtype.itemsize]
        return np.ascontiguousarray(cells).view(dtype)[..., 0]

    return read


def _true_motion(layout: Mapping[str, Any], column: Column) -> dict[str, NDArray[np.float32]]:
    """Return where the drones of a world were, and how they moved."""
    qpos, motion = column("qpos"), column("motion")  # (T, nq), (T, N, 6)
    pose = np.stack([qpos[:, address : address + 7] for address in layout["qpos"]], axis=1)  # (T, N, 7)
    angles = roll_pitch_yaw_deg(pose[..., 3:7])
    truth = {
        **{name: pose[..., i] for i, name in enumerate(_TRUE_POSE)},
        **{name: motion[..., i] for i, name in enumerate((*_TRUE_VELOCITY, *_TRUE_RATES))},
        **{name: angles[..., i] for i, name in enumerate(_TRUE_ATTITUDE)},
    }
    return {name: values.astype(np.float32) for name, values in truth.items()}


def motion_signals(group: str, position: Array, velocity: Array, orientation: Array) -> dict[str, NDArray[np.float32]]:
    """Return positions (m), velocities (m/s) and angles (deg) as signals, (T, N) each.

    Args:
        group: What their names begin with.
        position: Shape (T, N, 3).
        velocity: Shape (T, N, 3).
        orientation: Quaternions xyzw, shape (T, N, 4).
    """
    signals = {}
    for prefix, values in (("", position), ("v", velocity)):
        for k, axis in enumerate("xyz"):
            signals[f"{group}.{prefix}{axis}"] = values[..., k].astype(np.float32)
    angles = np.degrees(rpy_of_rotation(rotation_of_quaternion(orientation)))
    # the pitch of the onboard log is positive for a nose that rises
    for k, (name, sign) in enumerate((("roll", 1.0), ("pitch", -1.0), ("yaw", 1.0))):
        signals[f"{group}.{name}"] = (sign * angles[..., k]).astype(np.float32)
    return signals


def merged(names: Sequence[str], parts: Sequence[tuple[Sequence[int], Mapping[str, NDArray[Any]]]]) -> dict[str, Any]:
    """Return the signals of a swarm that several recorders saw, under the names of the first of them.

    What only the drones of the first have is NaN for the others; their truth is what is known of them.

    Args:
        names: All drones, N.
        parts: Which drones each recorder saw, and their signals, (T, n) each.
    """
    (first, signals), *others = parts
    whole = {}
    for name, values in signals.items():
        dtype = np.float64 if values.itemsize > 4 else np.float32
        whole[name] = np.full((len(values), len(names)), np.nan, dtype)
        whole[name][:, first] = values
        for numbers, theirs in others:
            known = theirs.get(name, theirs.get(name.replace("sim.", "stateEstimate.")))
            if known is not None:
                whole[name][:, numbers] = known
    return whole


def _joined(part_samples: Sequence[tuple[NDArray[np.intp], NDArray[Any]]], count: int) -> NDArray[Any]:
    """Return a signal of the whole swarm, shape (T, N), from those of its parts, each (T, n) with its columns."""
    columns, samples = part_samples[0]
    if len(part_samples) == 1 and len(columns) == count:
        return samples
    dtype = np.result_type(*(own for _, own in part_samples))
    if sum(len(columns) for columns, _ in part_samples) < count and dtype.kind != "f":
        # the smallest float that holds every value and NaN
        dtype = np.result_type(dtype, np.float16 if dtype.itemsize == 1 else np.float32)
    joined = np.zeros((len(samples), count), dtype)
    if dtype.kind == "f":
        joined[:] = np.nan
    for columns, own in part_samples:
        joined[:, columns] = own
    return joined


def roll_pitch_yaw_deg(quat_wxyz: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return roll, pitch and yaw (deg) of quaternions of shape (..., 4).

    Pitch has the legacy sign of the firmware, positive lifts the nose, so that it compares with
    ``stateEstimate.pitch``.
    """
    w, x, y, z = np.moveaxis(quat_wxyz, -1, 0)
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = -np.arcsin(np.clip(2 * (w * y - z * x), -1.0, 1.0))
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return np.degrees(np.stack([roll, pitch, yaw], axis=-1))
