"""Members of C structs as Python properties."""

from __future__ import annotations

from operator import attrgetter
from typing import Any

from crazychoir_fw.cffirmware.arrays import DTYPES, array_view, fill
from crazychoir_fw.cffirmware.numbers import integer, truth
from crazychoir_fw.cffirmware.struct_base import Struct, address, copy_references, refer, referred, view

_INTEGERS = ("char", "int")


def scalar(name: str, ctype: Any) -> property:
    """Return the property of a number or an enumeration."""
    if ctype.cname == "_Bool":
        convert: Any = truth
    elif ctype.kind == "enum" or ctype.cname not in ("float", "double"):
        convert = integer
    else:
        # cffi takes whatever is a number
        def set_float(self: Struct, value: Any) -> None:
            setattr(self._c, name, value)

        return property(attrgetter(f"_c.{name}"), set_float)

    def set_converted(self: Struct, value: Any) -> None:
        setattr(self._c, name, convert(value))

    return property(attrgetter(f"_c.{name}"), set_converted)


def nested(name: str, cls: type[Struct], offset: int) -> property:
    """Return the property of a struct within a struct: reading gives a live view, assigning copies."""
    addressof = cls._ffi.addressof
    has_pointers = cls._has_pointers

    def get(self: Struct) -> Any:
        return view(cls, addressof(getattr(self._c, name)), self)

    def put(self: Struct, value: Any) -> None:
        demand(value, cls, name)
        setattr(self._c, name, value._c[0])
        if has_pointers:
            copy_references(value, self, offset)

    return property(get, put)


def numbers(name: str, ctype: Any, offset: int) -> property:
    """Return the property of an array of numbers: reading gives a live NumPy view, assigning copies a sequence."""
    shape = []
    while ctype.kind == "array":
        shape.append(ctype.length)
        ctype = ctype.item
    dtype = DTYPES[ctype.cname]

    def get(self: Struct) -> Any:
        return array_view(address(self) + offset, tuple(shape), dtype, self)

    def put(self: Struct, value: Any) -> None:
        fill(get(self), value, name)

    return property(get, put)


class StructArray:
    """An array of structs within a struct."""

    def __init__(self, cls: type[Struct], pointer: Any, length: int, keep: Struct) -> None:
        self._class = cls
        self._pointer = pointer
        self._length = length
        self._keep = keep

    def __len__(self) -> int:
        return self._length

    def __getitem__(self, i: int) -> Any:
        return view(self._class, self._pointer + self._place(i), self._keep)

    def __setitem__(self, i: int, value: Any) -> None:
        demand(value, self._class, "element")
        self._pointer[self._place(i)] = value._c[0]

    def _place(self, i: int) -> int:
        if not 0 <= integer(i) < self._length:
            raise IndexError(f"index {i}; allowed: 0 to {self._length - 1}")
        return integer(i)


def structs(name: str, cls: type[Struct], length: int) -> property:
    """Return the property of an array of structs: reading gives live views, assigning copies a sequence."""
    addressof = cls._ffi.addressof

    def get(self: Struct) -> StructArray:
        return StructArray(cls, addressof(getattr(self._c, name)[0]), length, self)

    def put(self: Struct, values: Any) -> None:
        if len(values) != length:
            raise ValueError(f"{name} has {length} elements, not {len(values)}")
        array = get(self)
        for i, value in enumerate(values):
            array[i] = value

    return property(get, put)


def pointer_to_struct(name: str, cls: type[Struct], offset: int) -> property:
    """Return the property of a pointer to a struct. What it points at is kept alive; null is None."""

    def get(self: Struct) -> Any:
        pointer = getattr(self._c, name)
        if not pointer:
            return None
        kept = referred(self, offset)
        if isinstance(kept, cls) and kept._c == pointer:
            return kept
        return view(cls, pointer, self if kept is None else kept)

    def put(self: Struct, value: Any) -> None:
        if value is None:
            setattr(self._c, name, cls._ffi.NULL)
        else:
            demand(value, cls, name)
            setattr(self._c, name, value._c)
        refer(self, offset, value)

    return property(get, put)


def opaque_pointer(name: str, ctype: Any, offset: int, ffi: Any) -> property:
    """Return the property of any other pointer: null is None, otherwise something to be handed on."""

    def get(self: Struct) -> Any:
        pointer = getattr(self._c, name)
        return pointer or None

    def put(self: Struct, value: Any) -> None:
        if value is None:
            setattr(self._c, name, ffi.NULL)
        elif isinstance(value, ffi.CData):
            setattr(self._c, name, value)
        else:
            raise TypeError(f"{name} must be a pointer of C or None, not {value!r}")
        refer(self, offset, value)

    return property(get, put)


def demand(value: Any, cls: type[Struct], name: str) -> None:
    """Raise a TypeError unless a value is an object of a class."""
    if not isinstance(value, cls):
        raise TypeError(f"{name} must be {cls.__name__}, not {value!r}")
