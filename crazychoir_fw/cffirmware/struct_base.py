"""What every struct of the module can do: own memory or view another object's, and keep alive what it points at."""

from __future__ import annotations

from typing import Any


class Struct:
    """A C struct, or a live view of one that is part of another.

    Names that are no members of the C struct become ordinary Python attributes, as with SWIG.
    """

    __slots__ = ("__dict__", "__weakref__", "_c", "_keep", "_references")

    # of each class that is made from a C type
    _ffi: Any = None
    _pointer_type: Any = None
    _size = 0
    _member_names: tuple[str, ...] = ()
    _has_pointers = False

    def __init__(self) -> None:
        self._c = self._ffi.new(self._pointer_type)  # all zero
        self._keep: Any = None
        self._references: dict[int, Any] | None = None

    @property
    def this(self) -> Any:
        """The C pointer behind the object."""
        return self._c

    @property
    def thisown(self) -> bool:
        """Whether the object owns its memory. It can be set, without effect: the last reference frees the memory."""
        return not isinstance(self._keep, Struct)

    @thisown.setter
    def thisown(self, value: bool) -> None:
        pass

    def __repr__(self) -> str:
        members = ", ".join(f"{name}={getattr(self, name)!r}" for name in self._member_names)
        return f"{type(self).__name__}({members})"

    def __copy__(self) -> Struct:
        copy = type(self).__new__(type(self))
        Struct.__init__(copy)
        copy._c[0] = self._c[0]
        copy.__dict__.update(self.__dict__)
        if self._has_pointers:
            copy_references(self, copy, 0)
        return copy

    def __deepcopy__(self, memo: dict[int, Any]) -> Struct:
        return self.__copy__()

    def __reduce_ex__(self, protocol: Any) -> Any:
        raise TypeError(f"cannot pickle {type(self).__name__}: it is memory of C")


def own(cls: type[Struct], value: Any) -> Any:
    """Return an object around a struct that a C function returned by value."""
    made = cls.__new__(cls)
    made._c = cls._ffi.addressof(value)
    made._keep = value
    made._references = None
    return made


def view(cls: type[Struct], pointer: Any, keep: Any) -> Any:
    """Return an object around memory that lives at least as long as `keep` does."""
    made = cls.__new__(cls)
    made._c = pointer
    made._keep = keep
    made._references = None
    return made


def address(struct: Struct) -> int:
    """Return where the struct is."""
    return int(struct._ffi.cast("uintptr_t", struct._c))


def root(struct: Struct) -> Struct:
    """Return the object that a view is a view of."""
    while isinstance(struct._keep, Struct):
        struct = struct._keep
    return struct


def refer(struct: Struct, offset: int, target: Any) -> None:
    """Keep alive what the pointer at an offset of the struct points at; None if it points at nothing of ours."""
    owner = root(struct)
    if owner._references is None:
        owner._references = {}
    owner._references[address(struct) + offset] = target


def referred(struct: Struct, offset: int) -> Any:
    """Return what is kept alive for the pointer at an offset, or None."""
    return (root(struct)._references or {}).get(address(struct) + offset)


def copy_references(source: Struct, destination: Struct, offset: int) -> None:
    """Let `destination` keep alive what `source`, of which it has a copy at an offset, keeps alive."""
    begin = address(source)
    kept = root(destination)
    refer(destination, offset, referred(destination, offset))
    # pointers of the copy may lead into the source itself; no address is negative
    kept._references[-(address(destination) + offset)] = root(source)  # type: ignore[index]
    for place, target in list((root(source)._references or {}).items()):
        if begin <= place < begin + source._size:
            refer(destination, offset + place - begin, target)
