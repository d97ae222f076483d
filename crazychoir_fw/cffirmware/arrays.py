"""C arrays as NumPy views, and sequences as arguments for C arrays."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

DTYPES = {
    "float": np.float32,
    "double": np.float64,
    "int8_t": np.int8,
    "int16_t": np.int16,
    "int32_t": np.int32,
    "int": np.int32,
    "uint8_t": np.uint8,
    "unsigned char": np.uint8,
    "uint16_t": np.uint16,
    "uint32_t": np.uint32,
}


class _Memory:
    """Memory of C for NumPy, with the object that keeps it alive."""

    def __init__(self, address: int, shape: tuple[int, ...], dtype: Any, owner: Any) -> None:
        self.__array_interface__ = {
            "version": 3,
            "data": (address, False),
            "shape": shape,
            "typestr": np.dtype(dtype).str,
        }
        self.owner = owner


def array_view(address: int, shape: tuple[int, ...], dtype: Any, owner: Any) -> np.ndarray:
    """Return a writable array over memory of C; it keeps `owner` alive."""
    return np.asarray(_Memory(address, shape, dtype, owner))


def fill(target: np.ndarray, value: Any, name: str) -> None:
    """Copy a sequence into an array of C.

    Raises:
        TypeError: If it does not hold numbers, or fractions where integers belong.
        ValueError: If it has another shape.
        OverflowError: If an integer does not fit.
    """
    source = np.asarray(value)
    if source.dtype.kind not in ("biu" if target.dtype.kind in "iu" else "biuf"):
        raise TypeError(f"{name} must be {_whole(target)} of shape {target.shape}, not {value!r}")
    if source.shape != target.shape:
        raise ValueError(f"{name} has shape {target.shape}, not {source.shape}")
    if target.dtype.kind in "iu" and source.size:
        allowed = np.iinfo(target.dtype)
        if source.min() < allowed.min or source.max() > allowed.max:
            raise OverflowError(f"{name}: numbers must lie in [{allowed.min}, {allowed.max}]")
    target[...] = source


def _whole(target: np.ndarray) -> str:
    return "integers" if target.dtype.kind in "iu" else "numbers"


def argument_maker(ffi: Any, item: str) -> Callable[[Any, int, str, bool], tuple[Any, np.ndarray | None]]:
    """Return a function that makes the argument for a parameter ``item *``.

    It takes the value, how many numbers C reads or writes, the name for errors, and whether C writes. It returns the
    pointer and, if C writes to a copy, the array that must be copied back.
    """
    dtype = np.dtype(DTYPES[item])

    def argument(value: Any, count: int, name: str, written: bool) -> tuple[Any, np.ndarray | None]:
        if isinstance(value, ffi.CData):
            return value, None
        if written and value is None:
            return ffi.new(f"{item}[]", count), None
        if isinstance(value, str):
            raise TypeError(f"{name} must be a sequence of {count} numbers, not {value!r}")
        given = np.asarray(value)
        if given.dtype.kind not in "biuf" or given.ndim == 0:
            raise TypeError(f"{name} must be a sequence of {count} numbers, not {value!r}")
        if given.size < count:
            raise ValueError(f"{name} has {given.size} numbers, {count} are needed")
        if written and not (isinstance(value, list) or (given is value and given.flags.writeable)):
            raise TypeError(f"{name} is written to: it must be a list or a writable array, not {type(value).__name__}")
        if given.dtype == dtype and given.flags.c_contiguous and (given is value or not written):
            return ffi.from_buffer(f"{item}[]", given, require_writable=written), None
        copied = np.array(given, dtype=dtype, order="C")
        return ffi.from_buffer(f"{item}[]", copied), copied if written else None

    return argument


def copy_back(value: Any, copied: np.ndarray | None) -> None:
    """Put what C wrote to a copy into the list or array that the caller gave."""
    if copied is None:
        return
    if isinstance(value, list):
        value[:] = copied.tolist()
    else:
        value[...] = copied
