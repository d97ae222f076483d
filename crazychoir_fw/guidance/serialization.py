"""Data of agents to bytes and back: MessagePack by msgspec, with a short list of types, never pickles.

May be sent: None, bool, int (64 bits), float, str, bytes, list, tuple, dict, NumPy arrays of numbers, `Pose`. Types
survive the way, but for NumPy's scalars, which arrive as Python's. Arrays arrive read-only.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, get_args

import msgspec
import numpy as np
from msgspec.msgpack import Decoder, Encoder, Ext
from numpy.typing import NDArray

from crazychoir_fw.common.errors import MessageError
from crazychoir_fw.common.messages import Pose

LARGEST_BYTES = 1 << 20
"""Largest message (bytes), unless a caller allows more or less."""

DEEPEST = 16
"""How deep containers may be nested."""

MAX_DIMENSIONS = 8
"""Of an array."""

_Dtype = Literal["bool", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64", "float32", "float64"]
DTYPES = frozenset(get_args(_Dtype))
"""Types of numbers that arrays may have."""

_KINDS = {name: np.dtype(name).newbyteorder("<") for name in DTYPES}
_NAMES: dict[np.dtype[Any], Any] = {kind: name for name, kind in _KINDS.items()}
_ARRAY, _POSE, _TUPLE = 1, 2, 3  # MessagePack extension types
_PLAIN = frozenset([type(None), bool, int, float, str, bytes])
_ALLOWED = "allowed: None, bool, int, float, str, bytes, list, tuple, dict, numeric array, Pose"


class _Array(msgspec.Struct, array_like=True, forbid_unknown_fields=True, gc=False):
    dtype: _Dtype
    shape: Annotated[
        tuple[Annotated[int, msgspec.Meta(ge=0, le=LARGEST_BYTES)], ...], msgspec.Meta(max_length=MAX_DIMENSIONS)
    ]
    data: bytes  # little-endian

    @classmethod
    def of(cls, array: NDArray[Any]) -> _Array:
        if array.dtype not in _NAMES:
            array = array.astype(array.dtype.newbyteorder("<"))  # from a big-endian machine, or none that is allowed
        name = _NAMES.get(array.dtype)
        if name is None:
            raise MessageError(f"message holds an array of {array.dtype}, allowed: {', '.join(sorted(DTYPES))}")
        if array.ndim > MAX_DIMENSIONS:
            raise MessageError(f"message holds an array of {array.ndim} dimensions, allowed: {MAX_DIMENSIONS}")
        return cls(name, array.shape, array.tobytes())

    def array(self) -> NDArray[Any]:
        kind = _KINDS[self.dtype]
        if len(self.data) != math.prod(self.shape) * kind.itemsize:
            raise MessageError("message holds an array whose bytes do not fit its shape")
        if self.dtype == "bool" and self.data.strip(b"\x00\x01"):
            raise MessageError("message holds an array of truth values that are none")
        return np.frombuffer(self.data, kind).reshape(self.shape)


class _Pose(msgspec.Struct, array_like=True, forbid_unknown_fields=True, gc=False):
    position: _Array | None
    orientation: _Array | None
    velocity: _Array | None
    angular: _Array | None
    time: float | None

    @classmethod
    def of(cls, pose: Pose) -> _Pose:
        fields = (pose.position, pose.orientation, pose.velocity, pose.angular)
        vectors = [None if field is None else _Array.of(np.asarray(field)) for field in fields]
        return cls(*vectors, None if pose.time is None else float(pose.time))

    def pose(self) -> Pose:
        fields = (self.position, self.orientation, self.velocity, self.angular)
        return Pose(*[None if field is None else field.array() for field in fields], self.time)


def dumps(obj: object, limit: int = LARGEST_BYTES) -> bytes:
    """Return an object as bytes.

    Args:
        obj: What the module names, nested at most `DEEPEST` deep.
        limit: Most bytes.

    Raises:
        MessageError: If something in it may not be sent, or it is too large.
    """
    try:
        data = _encode(_plain(obj, DEEPEST))
    except (OverflowError, UnicodeError) as error:  # large integers, lone surrogates
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
    try:
        return _allowed(_decode(bytes(data)), DEEPEST)
    except (msgspec.MsgspecError, UnicodeError, RecursionError) as error:
        raise MessageError(f"message cannot be read: {type(error).__name__}: {error}") from error


def _plain(obj: object, depth: int) -> object:
    """Return it as what msgspec keeps; exact types only, for a subclass would arrive as something else."""
    kind = type(obj)
    if kind in _PLAIN:
        return obj
    if depth == 0:
        raise MessageError(f"message is nested too deep, allowed: {DEEPEST} levels")
    if kind is list:
        return [_plain(item, depth - 1) for item in obj]  # type: ignore[attr-defined]
    if kind is tuple:
        return Ext(_TUPLE, _encode([_plain(item, depth - 1) for item in obj]))  # type: ignore[attr-defined]
    if kind is dict:
        return {_key(key): _plain(item, depth - 1) for key, item in obj.items()}  # type: ignore[attr-defined]
    if isinstance(obj, np.ndarray):
        return Ext(_ARRAY, _encode(_Array.of(obj)))
    if isinstance(obj, Pose):
        return Ext(_POSE, _encode(_Pose.of(obj)))
    if isinstance(obj, np.bool_ | np.integer | np.floating) and obj.dtype.name in DTYPES:
        return obj.item()
    raise MessageError(f"message holds a {kind.__name__}, {_ALLOWED}")


def _key(key: object) -> object:
    if type(key) not in _PLAIN:
        raise MessageError(
            f"message has a key of type {type(key).__name__}, allowed: None, bool, int, float, str, bytes"
        )
    return key


def _extension(code: int, body: memoryview) -> Any:
    """Return the tuple, array or pose that msgspec meets while it reads."""
    if code == _TUPLE:
        return tuple(_decode_items(body))
    if code == _ARRAY:
        return _decode_array(body).array()
    if code == _POSE:
        return _decode_pose(body).pose()
    raise MessageError(f"message holds the unknown type {code}")


def _allowed(obj: Any, depth: int) -> Any:
    """Return it, if it is nested no deeper and holds nothing that `dumps` would refuse."""
    kind = type(obj)
    if kind is list or kind is tuple or kind is dict:
        if depth == 0:
            raise MessageError(f"message is nested too deep, allowed: {DEEPEST} levels")
        if kind is dict:
            for key in obj:
                _key(key)
        for item in obj.values() if kind is dict else obj:
            _allowed(item, depth - 1)
    elif kind not in _PLAIN and kind is not np.ndarray and kind is not Pose:
        raise MessageError(f"message holds a {kind.__name__}, {_ALLOWED}")  # such as a time stamp
    return obj


_encode = Encoder().encode
_decode = Decoder(ext_hook=_extension).decode
_decode_items = Decoder(list, ext_hook=_extension).decode
_decode_array = Decoder(_Array).decode
_decode_pose = Decoder(_Pose).decode
