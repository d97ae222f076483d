"""Data of agents to bytes and back: msgpack with a short list of types, never pickles.

May be sent: None, bool, int (64 bits), float, str, bytes, list, tuple, dict, NumPy arrays of numbers, `Pose`. Types
survive the way, but for NumPy's scalars, which arrive as Python's. Arrays arrive read-only.
"""

from __future__ import annotations

import struct
import sys
from typing import Any

import msgpack
import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import MessageError
from crazychoir_fw.common.messages import Pose

LARGEST_BYTES = 1 << 20
"""Largest message (bytes), unless a caller allows more or less."""

DEEPEST = 16
"""How deep containers may be nested."""

DTYPES = frozenset(
    ["bool", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64", "float32", "float64"]
)
"""Types of numbers that arrays may have."""

_ARRAY, _POSE, _TUPLE = 1, 2, 3  # msgpack extension types
_MAX_DIMENSIONS = 8
_KEYS = (type(None), bool, int, float, str, bytes)
_PLAIN = frozenset(_KEYS)
_ALLOWED = "allowed: None, bool, int, float, str, bytes, list, tuple, dict, numeric array, Pose"


def dumps(obj: object, limit: int = LARGEST_BYTES) -> bytes:
    """Return an object as bytes.

    Args:
        obj: What the module names, nested at most `DEEPEST` deep.
        limit: Most bytes.

    Raises:
        MessageError: If something in it may not be sent, or it is too large.
    """
    if isinstance(obj, Pose):
        data = _pack_full_pose(obj)
        if data is not None and len(data) <= limit:
            return data
    try:
        data = _pack(_plain(obj, DEEPEST))
    except (OverflowError, ValueError, UnicodeError) as error:  # of msgpack: large integers, lone surrogates
        if isinstance(error, MessageError):
            raise
        raise MessageError(f"message cannot be packed: {error}") from error
    if len(data) > limit:
        raise MessageError(f"message has {len(data)} bytes, allowed: {limit}")
    return data


def loads(data: bytes, limit: int = LARGEST_BYTES) -> Any:
    """Return the object that bytes from anywhere hold.

    Args:
        data: From `dumps`; anything else is refused.
        limit: Most bytes.

    Raises:
        MessageError: If they hold something else than `dumps` writes, or are too many.
    """
    if len(data) > limit:
        raise MessageError(f"message has {len(data)} bytes, allowed: {limit}")
    if len(data) == _FULL_POSE.size:
        pose = _unpack_full_pose(data)
        if pose is not None:
            return pose
    return _unpack(bytes(data), DEEPEST + 1)  # a tuple is unpacked inside of its own level


def _pack(plain: object) -> bytes:
    return msgpack.packb(plain, use_bin_type=True, strict_types=True)


def _plain(obj: object, depth: int) -> object:
    """Return it as what msgpack knows; exact types only, for a subclass would arrive as something else."""
    kind = type(obj)
    if kind in _PLAIN:
        return obj
    if depth == 0:
        raise MessageError(f"message is nested too deep, allowed: {DEEPEST} levels")
    if kind is list:
        return [_plain(item, depth - 1) for item in obj]  # type: ignore[attr-defined]
    if kind is tuple:
        return msgpack.ExtType(_TUPLE, _pack([_plain(item, depth - 1) for item in obj]))  # type: ignore[attr-defined]
    if kind is dict:
        return {_key(key): _plain(item, depth - 1) for key, item in obj.items()}  # type: ignore[attr-defined]
    if isinstance(obj, np.ndarray):
        return msgpack.ExtType(_ARRAY, _pack(_array_fields(obj)))
    if isinstance(obj, np.bool_ | np.integer | np.floating) and obj.dtype.name in DTYPES:
        return obj.item()
    if isinstance(obj, Pose):
        fields = [obj.position, obj.orientation, obj.velocity, obj.angular]
        fields = [None if field is None else _array_fields(np.asarray(field)) for field in fields]
        time = None if obj.time is None else float(obj.time)
        return msgpack.ExtType(_POSE, _pack([*fields, time]))
    raise MessageError(f"message holds a {kind.__name__}, {_ALLOWED}")


def _key(key: object) -> object:
    if type(key) not in _PLAIN:
        raise MessageError(
            f"message has a key of type {type(key).__name__}, allowed: None, bool, int, float, str, bytes"
        )
    return key


def _array_fields(array: NDArray[Any]) -> list[object]:
    if array.dtype.name not in DTYPES:
        raise MessageError(f"message holds an array of {array.dtype}, allowed: {', '.join(sorted(DTYPES))}")
    if array.ndim > _MAX_DIMENSIONS:
        raise MessageError(f"message holds an array of {array.ndim} dimensions, allowed: {_MAX_DIMENSIONS}")
    if array.dtype.byteorder == ">" or (array.dtype.byteorder == "=" and sys.byteorder == "big"):
        array = array.astype(array.dtype.newbyteorder("<"))
    return [array.dtype.name, list(array.shape), array.tobytes()]


def _unpack(data: bytes, depth: int) -> Any:
    if depth < 0:
        raise MessageError(f"message is nested too deep, allowed: {DEEPEST} levels")

    def extension(code: int, body: bytes) -> Any:
        # called while msgpack reads, once per tuple, array and pose
        if code == _TUPLE:
            items = _unpack(body, depth - 1)
            if not isinstance(items, list):
                raise MessageError("message holds a tuple that is none")
            return tuple(items)
        if code == _ARRAY:
            return _array(_unpack(body, 3))
        if code == _POSE:
            return _pose(_unpack(body, 4))
        raise MessageError(f"message holds the unknown type {code}")

    try:
        return _not_deep(msgpack.unpackb(data, ext_hook=extension, raw=False, strict_map_key=False), depth)
    except MessageError:
        raise
    except (ValueError, TypeError, OverflowError, RecursionError, msgpack.UnpackException) as error:
        # TypeError: a key that cannot be hashed
        raise MessageError(f"message cannot be read: {type(error).__name__}: {error}") from error


def _not_deep(obj: Any, depth: int) -> Any:
    if depth < 0:
        raise MessageError(f"message is nested too deep, allowed: {DEEPEST} levels")
    if type(obj) is list:
        for item in obj:
            _not_deep(item, depth - 1)
    elif type(obj) is dict:
        for key, item in obj.items():
            _key(key)
            _not_deep(item, depth - 1)
    elif isinstance(obj, msgpack.Timestamp):
        raise MessageError(f"message holds a time stamp, {_ALLOWED}")
    return obj


def _array(fields: Any) -> NDArray[Any]:
    if not (type(fields) is list and len(fields) == 3):
        raise MessageError("message holds an array that is none")
    name, shape, data = fields
    if not (isinstance(name, str) and name in DTYPES):
        raise MessageError(f"message holds an array of {name!r:.40}, allowed: {', '.join(sorted(DTYPES))}")
    if not (
        type(shape) is list
        and len(shape) <= _MAX_DIMENSIONS
        and all(type(size) is int and 0 <= size <= LARGEST_BYTES for size in shape)
    ):
        raise MessageError("message holds an array without a proper shape")
    dtype = np.dtype(name).newbyteorder("<")
    count = 1
    for size in shape:
        count *= size
    if type(data) is not bytes or len(data) != count * dtype.itemsize:
        raise MessageError("message holds an array whose bytes do not fit its shape")
    if name == "bool" and data.strip(b"\x00\x01"):
        raise MessageError("message holds an array of truth values that are none")
    return np.frombuffer(data, dtype=dtype).reshape(shape)


def _pose(fields: Any) -> Pose:
    if not (type(fields) is list and len(fields) == 5):
        raise MessageError("message holds a pose that is none")
    *vectors, time = fields
    if time is not None and type(time) is not float:
        raise MessageError("message holds a pose whose time is no number")
    return Pose(*[None if vector is None else _array(vector) for vector in vectors], time)


# A pose of which everything is known is what agents send a hundred times a second. Its bytes differ in 14 numbers only,
# which are put between what always stays, instead of being made by msgpack (60 µs).
_FULL_SIZES = (3, 4, 3, 3)


def _split_full_pose() -> tuple[list[bytes], struct.Struct]:
    """Return the bytes between the numbers, and how both follow each other."""
    marks = [np.full(size, 1.5 + k) for k, size in enumerate(_FULL_SIZES)]
    rest, parts, layout = _pack(_plain(Pose(*marks, 9.5), DEEPEST)), [], "<"
    for mark in marks:
        part, _, rest = rest.partition(mark.tobytes())
        parts.append(part)
        layout += f"{len(part)}s{len(mark)}d"
    part = rest[: -struct.calcsize("d")]
    return [*parts, part], struct.Struct(f"{layout}{len(part)}s8s")


_FULL_PARTS, _FULL_POSE = _split_full_pose()
_FULL_TIME = struct.Struct(">d")  # as msgpack has it


def _pack_full_pose(pose: Pose) -> bytes | None:
    """Return a pose as bytes, or None if it has to be packed the long way."""
    p, q, v, w = pose.position, pose.orientation, pose.velocity, pose.angular
    if type(pose.time) is not float:
        return None
    for vector, size in zip((p, q, v, w), _FULL_SIZES, strict=True):
        if type(vector) is not np.ndarray or vector.dtype != np.float64 or vector.shape != (size,):
            return None
    a, b, c, d, e = _FULL_PARTS
    return _FULL_POSE.pack(a, *p, b, *q, c, *v, d, *w, e, _FULL_TIME.pack(pose.time))  # type: ignore[misc]


def _unpack_full_pose(data: bytes) -> Pose | None:
    """Return a pose of which everything is known, or None if the bytes are something else."""
    a, px, py, pz, b, qx, qy, qz, qw, c, vx, vy, vz, d, wx, wy, wz, e, time = _FULL_POSE.unpack(data)
    if [a, b, c, d, e] != _FULL_PARTS:
        return None
    numbers = np.array((px, py, pz, qx, qy, qz, qw, vx, vy, vz, wx, wy, wz))
    numbers.flags.writeable = False
    return Pose(numbers[:3], numbers[3:7], numbers[7:10], numbers[10:], _FULL_TIME.unpack(time)[0])
