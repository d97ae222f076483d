"""Objects of the classes that a mission names, ours or the user's, made as it says."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from crazychoir_fw.common.errors import CrazychoirError, MissionError, RangeError, UnknownNameError
from crazychoir_fw.common.user_code import describe, load_module

if TYPE_CHECKING:
    from crazychoir_fw.mission.schema import LayeredMission


def class_of(mission: LayeredMission, key: str, word: str, stock: Any, base: type | None) -> type:
    """Return the class of a word; a file of the user's is executed once per mission.

    Args:
        mission: The mission.
        key: Where the word stands in its file.
        word: Name of a class, or module:Class.
        stock: Package of our own classes.
        base: What the class must derive from.

    Raises:
        CrazychoirError: If there is no such class.
    """
    classes = mission.__dict__.setdefault("_layer_classes", {})
    if (word, base) not in classes:
        classes[word, base] = _class(word, stock, base, key)
    return classes[word, base]


def _class(word: str, stock: Any, base: type | None, key: str) -> type:
    """Return the class of a word: one of ours, or one of the user's, whose module is executed.

    Raises:
        UnknownNameError: If there is no such class.
        RangeError: If it is of another kind.
    """
    module_name, colon, class_name = word.rpartition(":")
    if not colon:
        return getattr(stock, word) if hasattr(stock, word) else getattr(_schemes(), word)
    what = f"{key} '{word}'"
    module = load_module(module_name, what)
    found = getattr(module, class_name, None)
    if found is None:
        own = [
            name
            for name, value in vars(module).items()
            if isinstance(value, type) and value.__module__ == module.__name__
        ]
        raise UnknownNameError(f"{what}: there is no such class, only {', '.join(own) or 'none at all'}")
    if not isinstance(found, type) or (base is not None and not issubclass(found, base)):
        must = f"a subclass of {base.__name__}" if base is not None else "a class"
        raise RangeError(f"{what}: {found!r} is allowed to be {must} only")
    return found


def _schemes() -> Any:
    """Return the package of guidance that optimizes; whoever does without it need not load it."""
    from crazychoir_fw.guidance import schemes

    return schemes


def build(cls: type, key: str, arguments: Mapping[str, Any], options: Mapping[str, Any]) -> Any:
    """Return an object, given as much of what is known as its class asks for, and all that the file says.

    Raises:
        MissionError: If it cannot be made.
    """
    asked = inspect.signature(cls).parameters
    takes_all = any(parameter.kind is parameter.VAR_KEYWORD for parameter in asked.values())
    for name in options:
        if name not in asked and not takes_all:
            raise MissionError(f"{key}.options has no key '{name}', but only {', '.join(asked)}")
    known = {name: value for name, value in arguments.items() if name in asked or takes_all}
    try:
        return cls(**{**known, **options})
    except CrazychoirError as error:
        raise MissionError(f"{key}: {error}") from error
    except Exception as error:  # a user's code may raise anything
        raise MissionError(f"{key}: {cls.__name__} cannot be made: {describe(error)}") from error


def changed_gains(key: str, given: Mapping[str, Any], sets: Mapping[str, Any], kind: type, default: str) -> Any:
    """Return a set of gains that differs from another one.

    Args:
        key: Where it stands in the file.
        given: What differs, and from which set, `base`.
        sets: All sets, by name.
        kind: Their class.
        default: Name of the set that it differs from, if not told.

    Raises:
        MissionError: If it cannot be made.
    """
    base = given.get("base", default)
    if base not in sets:
        raise MissionError(f"{key}.base is {base!r}, but must be one of {', '.join(sets)}")
    known = [member.name for member in dataclasses.fields(kind)]
    changes = {name: value for name, value in given.items() if name != "base"}
    for name in changes:
        if name not in known:
            raise MissionError(f"{key} has no key '{name}', but only base, {', '.join(known)}")
    try:
        return dataclasses.replace(
            sets[base], **{k: tuple(v) if isinstance(v, list) else v for k, v in changes.items()}
        )
    except CrazychoirError as error:
        raise MissionError(f"{key}: {error}") from error
