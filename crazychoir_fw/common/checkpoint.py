"""Turns a flight back: each layer says its state, and takes it back later."""

from __future__ import annotations

import copy
from collections.abc import Iterable
from typing import Any, ClassVar

from crazychoir_fw.common.errors import StateError

_LAYERS = "layers"  # in the memo of a copy: those that it has met


class Stateful:
    """A layer of a flight, such as a law, a controller, a communicator or a backend, whose state can be restored.

    It stays the same object and gets its attributes back, so that closures and callbacks still know it. What it holds
    is copied, but for other layers, which stay the same objects too.
    """

    unkept: ClassVar[tuple[str, ...]] = ()
    """Attributes that stay as they are: locks, handles of libraries, callbacks of others."""

    def state(self) -> dict[str, Any]:
        """Return what may change in flight, by name; a `Checkpoint` copies it."""
        return {name: value for name, value in vars(self).items() if name not in self.unkept}

    def restore(self, state: dict[str, Any]) -> None:
        """Take what `state` returned, or a copy of it."""
        for name in vars(self).keys() - state.keys() - set(self.unkept):
            delattr(self, name)
        vars(self).update(state)

    def __deepcopy__(self, memo: dict[Any, Any]) -> Any:
        """Return a copy, or within a checkpoint the layer itself, whose state is kept as well."""
        if _LAYERS in memo:
            memo[_LAYERS].append(self)
            return self
        other = memo[id(self)] = type(self).__new__(type(self))
        vars(other).update(copy.deepcopy(vars(self), memo))
        return other


class Checkpoint:
    """What layers, and those that they hold, are at this instant. Objects that several share are shared again later."""

    def __init__(self, layers: Iterable[Stateful]) -> None:
        """Copy the states.

        Raises:
            StateError: If that of one cannot be copied; the text says what helps.
        """
        self._states: list[tuple[Stateful, dict[str, Any]]] = []
        waiting, seen = list(layers), set()
        memo: dict[Any, Any] = {_LAYERS: waiting}
        while waiting:
            layer = waiting.pop()
            if id(layer) in seen:
                continue
            seen.add(id(layer))
            cls = type(layer)  # a law may have an attribute named state
            try:
                self._states.append((layer, copy.deepcopy(cls.state(layer), memo)))
            except Exception as error:  # a user's objects may be of any kind
                raise StateError(
                    f"{cls.__name__}: {error}; {cls.__name__}.unkept may name what stays as it is"
                ) from None

    def restore(self) -> None:
        """Make all of them what they were; may be called again."""
        for layer, state in copy.deepcopy(self._states, {_LAYERS: []}):
            type(layer).restore(layer, state)
