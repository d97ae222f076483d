"""Remembers what Python objects are at an instant, and makes them that again, in place.

Layers of a flight are objects of many classes, some of them a user's, that hold each other, locks and closures. A deep
copy of them would be other objects, which closures do not know; so each object keeps its identity, and gets back what
it held.
"""

from __future__ import annotations

import types
from collections import OrderedDict, defaultdict, deque
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

_ATOMS = (
    *(int, float, complex, bool, str, bytes, type(None), type, range, slice),
    *(types.ModuleType, types.BuiltinFunctionType, types.CodeType, types.GeneratorType, np.generic, np.dtype),
)
_MAPPINGS = (dict, OrderedDict, defaultdict)


class Memory:
    """What all objects within reach of some others are at this instant."""

    def __init__(self, roots: Iterable[Any], leaves: Iterable[Any] = ()) -> None:
        """Look at everything within reach.

        Args:
            roots: Where to begin.
            leaves: Objects that are neither looked at nor into.
        """
        self._leaves = list(leaves)  # kept, so that no other object gets their ids
        self._kept: list[tuple[Any, Any]] = []
        self._look(list(roots))

    def __len__(self) -> int:
        return len(self._kept)

    def restore(self) -> None:
        """Make all of them what they were."""
        for thing, state in self._kept:
            _put(thing, state)

    def _look(self, waiting: list[Any]) -> None:
        seen = {id(leaf) for leaf in self._leaves}
        while waiting:
            thing = waiting.pop()
            if isinstance(thing, _ATOMS) or id(thing) in seen:
                continue
            seen.add(id(thing))
            state, parts = _take(thing)
            if state is not None:
                self._kept.append((thing, state))
            waiting.extend(parts)


def _take(thing: Any) -> tuple[Any, Iterable[Any]]:
    """Return what an object holds by itself, or None if that cannot change, and what it refers to."""
    kind = type(thing)
    if kind is np.ndarray:
        return thing.copy(), thing.ravel().tolist() if thing.dtype.hasobject else ()
    if kind in _MAPPINGS:
        return dict(thing), thing.values()
    if kind in (list, deque, set):
        return kind(thing) if kind is not deque else list(thing), thing
    if kind in (tuple, frozenset):
        return None, thing
    if kind is types.MethodType:
        return None, (thing.__self__,)
    if kind is types.FunctionType:
        return None, (*(thing.__closure__ or ()), *(thing.__defaults__ or ()))
    if kind is types.CellType:
        try:
            return (thing.cell_contents,), (thing.cell_contents,)
        except ValueError:  # not bound yet
            return None, ()
    if isinstance(thing, np.random.Generator):
        return thing.bit_generator.state, ()
    attributes = getattr(thing, "__dict__", None)
    slots = list(_slots(thing))
    if attributes is None and not slots:
        return None, ()  # a lock, a handle of a library: shared by then and now
    inner: list[Any] = list(attributes.values()) if attributes else []
    inner += [value for _, value in slots]
    contents = None
    if isinstance(thing, (*_MAPPINGS, list, deque, set)):  # of a subclass
        contents = dict(thing) if isinstance(thing, dict) else list(thing)
        inner += list(thing.values()) if isinstance(thing, dict) else list(thing)
    return (None if attributes is None else dict(attributes), slots, contents), inner


def _put(thing: Any, state: Any) -> None:
    kind = type(thing)
    if kind is np.ndarray:
        if thing.flags.writeable:
            thing[...] = state
    elif kind in _MAPPINGS or kind is set:
        thing.clear()
        thing.update(state)
    elif kind is list:
        thing[:] = state
    elif kind is deque:
        thing.clear()
        thing.extend(state)
    elif kind is types.CellType:
        thing.cell_contents = state[0]
    elif isinstance(thing, np.random.Generator):
        thing.bit_generator.state = state
    else:
        attributes, slots, contents = state
        if attributes is not None:
            thing.__dict__.clear()
            thing.__dict__.update(attributes)
        for name, value in slots:
            object.__setattr__(thing, name, value)
        if contents is not None:
            thing.clear()
            (thing.update if isinstance(thing, dict | set) else thing.extend)(contents)


def _slots(thing: Any) -> Iterator[tuple[str, Any]]:
    for cls in type(thing).__mro__:
        names = cls.__dict__.get("__slots__", ())
        for name in (names,) if isinstance(names, str) else names:
            if name not in ("__dict__", "__weakref__") and hasattr(thing, name):
                yield name, getattr(thing, name)
