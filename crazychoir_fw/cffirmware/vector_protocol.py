"""What `vec` can do in Python beside holding three numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from crazychoir_fw.cffirmware.struct_base import Struct, own


class VectorProtocol(Struct):
    """Arithmetic, indexing and conversion of `vec`; float32, rounded as in C."""

    __slots__ = ()

    # functions of the C library
    _add: Any = None
    _subtract: Any = None
    _negate: Any = None
    _scale: Any = None
    _divide: Any = None

    def __repr__(self) -> str:
        return f"({self.x!r}, {self.y!r}, {self.z!r})"

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        if copy is False:
            raise ValueError("vec is float32 of C: as an array it is always a copy")
        return np.array([self.x, self.y, self.z], dtype=np.float64 if dtype is None else dtype)

    def __len__(self) -> int:
        return 3

    def __getitem__(self, i: int) -> float:
        if i == 0:
            return self._c.x
        if i == 1:
            return self._c.y
        if i == 2:
            return self._c.z
        raise IndexError(f"index {i}; allowed: 0 to 2")

    def __neg__(self) -> Any:
        return own(type(self), self._negate(self._c[0]))

    def __add__(self, other: Any) -> Any:
        if not isinstance(other, type(self)):
            return NotImplemented
        return own(type(self), self._add(self._c[0], other._c[0]))

    def __sub__(self, other: Any) -> Any:
        if not isinstance(other, type(self)):
            return NotImplemented
        return own(type(self), self._subtract(self._c[0], other._c[0]))

    def __rmul__(self, factor: Any) -> Any:
        if isinstance(factor, Struct):
            return NotImplemented
        return own(type(self), self._scale(factor, self._c[0]))

    def __truediv__(self, divisor: Any) -> Any:
        if isinstance(divisor, Struct):
            return NotImplemented
        return own(type(self), self._divide(self._c[0], divisor))
