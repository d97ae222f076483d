"""C structs as rows of NumPy arrays, so that a recording is an array and a row is what a C function takes."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi

_SCALARS = {
    "float": "f4",
    "double": "f8",
    "_Bool": "?",
    "int8_t": "i1",
    "int16_t": "i2",
    "int32_t": "i4",
    "int64_t": "i8",
    "uint8_t": "u1",
    "uint16_t": "u2",
    "uint32_t": "u4",
    "uint64_t": "u8",
    "int": "i4",
    "unsigned char": "u1",
    "unsigned int": "u4",
}

# of members that share memory, the first ones are taken; here others hold every byte or have the better names
_VIEWS = {
    "control_t": ("normalizedForces", "controlMode"),
    "quaternion_t": ("x", "y", "z", "w"),
}


@functools.cache
def dtype_of(c_name: str) -> np.dtype:
    """Return the NumPy type of a C struct: same size, same offsets, no two fields over the same bytes.

    Unions without a name for every byte become plain bytes, pointers whole numbers.
    """
    return _dtype(ffi.typeof(c_name))


def _dtype(c_type: Any) -> np.dtype:
    if c_type.kind == "primitive":
        return np.dtype(_SCALARS[c_type.cname])
    if c_type.kind == "enum":
        return np.dtype("u4" if ffi.sizeof(c_type) == 4 else "u1")
    if c_type.kind in ("pointer", "function"):
        return np.dtype("u8")
    if c_type.kind == "array":
        return np.dtype((_dtype(c_type.item), (c_type.length,)))
    if c_type.kind == "union" and c_type.cname.startswith("union $"):
        return np.dtype(("u1", (ffi.sizeof(c_type),)))
    names, formats, offsets = [], [], []
    wanted = _VIEWS.get(c_type.cname)
    end = 0
    for name, field in c_type.fields:
        if field.offset >= end if wanted is None else name in wanted:
            names.append(name)
            formats.append(_dtype(field.type))
            offsets.append(field.offset)
            end = field.offset + ffi.sizeof(field.type)
    return np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": ffi.sizeof(c_type)})


def zeros(c_name: str, count: int) -> NDArray[Any]:
    """Return an array of that many C structs, all bytes zero."""
    return np.zeros(count, dtype_of(c_name))


def pointer(rows: NDArray[Any], c_name: str) -> Any:
    """Return a C pointer to the first row of a contiguous array; the caller keeps the array alive."""
    if not rows.flags.c_contiguous or rows.dtype.itemsize != ffi.sizeof(c_name):
        raise ValueError(f"rows of {rows.dtype.itemsize} bytes, or not contiguous; {c_name} has {ffi.sizeof(c_name)}")
    return ffi.cast(f"{c_name} *", rows.ctypes.data)


def joined_rows(parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Return arrays of one kind of struct one after the other; `numpy.concatenate` would drop the padding."""
    dtype = parts[0].dtype
    raw = [np.ascontiguousarray(part).view(np.uint8) for part in parts]
    return np.concatenate(raw).view(dtype)


def columns(rows: NDArray[Any], prefix: str = "") -> dict[str, NDArray[Any]]:
    """Return every number of an array of structs as a signal: ``position.x``, ``mode.yaw``, ``list.0``.

    Args:
        rows: A structured array of shape (T,).
        prefix: Put before each name, with a dot.

    Returns:
        Name to values of shape (T,), in the order of the struct.
    """
    found: dict[str, NDArray[Any]] = {}
    for name in rows.dtype.names or ():
        _collect(rows[name], f"{prefix}.{name}" if prefix else name, found)
    return found


def _collect(values: NDArray[Any], name: str, found: dict[str, NDArray[Any]]) -> None:
    if values.dtype.names:
        found.update(columns(values, name))
    elif values.ndim > 1:
        for i in range(values.shape[1]):
            _collect(values[:, i], f"{name}.{i}", found)
    else:
        found[name] = values
