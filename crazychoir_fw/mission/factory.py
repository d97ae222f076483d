"""Objects of the classes that a mission names, ours or the user's, made as it says."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from crazychoir_fw.common.errors import CrazychoirError, MissionError
from crazychoir_fw.common.user_code import USER_ERRORS, describe
from crazychoir_fw.guidance.law import arguments_of
from crazychoir_fw.mission.registry import law_named
from crazychoir_fw.mission.section import Section
from crazychoir_fw.mission.values import did_you_mean


def class_of(section: Section, kind: str, key: str, word: str, base: type | None) -> type:
    """Return the law that a section of a mission names; a file of the user's is executed once per section.

    Args:
        section: The section.
        kind: Of the law, see `crazychoir_fw.mission.registry`.
        key: Where the word stands in the file.
        word: The name.
        base: What the law must derive from.

    Raises:
        CrazychoirError: If there is no such law.
    """
    laws = section.__dict__.setdefault("_laws", {})
    if (kind, word) not in laws:
        laws[kind, word] = law_named(kind, word, key, base)
    return laws[kind, word]


def build(cls: type, key: str, arguments: Mapping[str, Any], options: Mapping[str, Any]) -> Any:
    """Return an object, given as much of what is known as its class asks for, and all that the file says.

    Raises:
        MissionError: If it cannot be made.
    """
    asked = arguments_of(cls)
    for name in options:
        if name not in asked:
            hint = did_you_mean(name, asked)
            raise MissionError(f"{key}.options has no key '{name}'{hint}, but only {', '.join(asked)}")
    known = {name: value for name, value in arguments.items() if name in asked}
    try:
        return cls(**{**known, **options})
    except CrazychoirError as error:
        raise MissionError(f"{key}: {error}") from error
    except USER_ERRORS as error:  # a user's code may raise anything
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
