"""What the sections of `layers` have in common: classes by word, gains, options, names and rates."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Annotated, Any

from pydantic import BeforeValidator, ValidationInfo

from crazychoir_fw.common.constraints import word
from crazychoir_fw.mission.registry import installed_names, our_names
from crazychoir_fw.mission.values import did_you_mean, existing_file, refusal

RATES = (10, 20, 25, 50, 100)
"""Rounds per second (Hz): whole steps of every backend."""


def class_word(kind: str) -> BeforeValidator:
    """A law by a name of the registry, or one of the user's: package.module:Class or file.py:Class."""

    def check(value: object, info: ValidationInfo) -> str:
        if isinstance(value, str) and (value in our_names(kind) or value in installed_names(kind)):
            return value
        known = [*our_names(kind), *installed_names(kind)]
        must = f"one of {', '.join(known)}, package.module:Class or file.py:Class"
        if not isinstance(value, str) or not re.fullmatch(r"(.*\.py|[\w.]+):[^\W\d]\w*", value):
            raise refusal(must + did_you_mean(value, known))
        file, _, class_name = value.rpartition(":")
        if not file.endswith(".py"):
            return value
        return f"{existing_file(file, info, must).resolve()}:{class_name}"

    return BeforeValidator(check)


def gain_set() -> BeforeValidator:
    """The name of a set of gains, or a mapping of what differs from the default set."""
    must = "the name of a set of gains, or a mapping such as {k_p: 0.2, k_v: [1, 1, 1]}"

    def is_gain(value: object) -> bool:
        items = value if isinstance(value, Sequence) and not isinstance(value, str | bytes) else [value]
        return len(items) in (1, 3) and all(
            isinstance(item, int | float) and not isinstance(item, bool) and -1e6 <= item <= 1e6 for item in items
        )

    def check(value: object) -> str | dict[str, Any]:
        if isinstance(value, str) and re.fullmatch(r"[a-z]\w{0,30}", value):
            return value
        is_mapping = isinstance(value, Mapping) and len(value) > 0
        if is_mapping and all(
            isinstance(key, str) and (is_gain(item) or key == "base")
            for key, item in value.items()  # type: ignore[union-attr]
        ):
            return dict(value)  # type: ignore[call-overload]
        raise refusal(must)

    return BeforeValidator(check)


def law_gains() -> BeforeValidator:
    """The name of a set of gains of all laws, or one for each kind of law."""
    must = "the name of a set of gains, or a mapping of position, attitude, velocity to one each"
    of_one = gain_set().func

    def check(value: object) -> str | dict[str, Any]:
        if isinstance(value, Mapping) and value:
            if set(value) <= {"position", "attitude", "velocity"}:
                return {key: of_one(item) for key, item in value.items()}  # type: ignore[call-arg]
        elif isinstance(value, str):
            return of_one(value)  # type: ignore[call-arg]
        raise refusal(must)

    return BeforeValidator(check)


def plain_options() -> BeforeValidator:
    """Keyword arguments for a class of the user's."""
    must = "a mapping from words to plain values, such as {radius: 0.5}"

    def check(value: object) -> dict[str, Any]:
        if not isinstance(value, Mapping) or not all(
            isinstance(key, str) and key.isidentifier() and not key.startswith("_") for key in value
        ):
            raise refusal(must)
        return dict(value)

    return BeforeValidator(check)


def _rate(value: object) -> int:
    if isinstance(value, bool) or value not in RATES:
        raise refusal(f"one of {', '.join(map(str, RATES))} Hz")
    return int(value)  # type: ignore[call-overload]


Name = Annotated[str, word(r"[A-Za-z]\w{0,30}", "the id of a drone")]
Options = Annotated[Mapping[str, Any], plain_options()]
Gains = Annotated[str | Mapping[str, Any], gain_set()]
Rate = Annotated[int, BeforeValidator(_rate)]
