"""What a file says of a motor control, as text: the name of its class, and its properties."""

from __future__ import annotations

import shlex
from collections.abc import Mapping

from crazychoir_fw.common.errors import RangeError

STOCK = ("MotorCtrlFPQR", "MotorCtrlFRPY", "MotorCtrlVel", "MotorCtrlXYZ")
"""Classes of the package `motor_ctrl` that are known by their plain names."""


def class_name(cls: type) -> str:
    """Return the name by which `find_class` finds a class again, as far as its module can be imported."""
    is_stock = cls.__name__ in STOCK and cls.__module__.startswith(f"{__package__}.motor_ctrl.")
    return cls.__name__ if is_stock else f"{cls.__module__}:{cls.__qualname__}"


def require_class(who: str, motor_ctrl: object, properties: Mapping[str, object]) -> None:
    """Refuse properties without a motor control that reads them.

    Raises:
        RangeError: If there are properties, but no class.
    """
    if motor_ctrl is None and properties:
        words = ", ".join(str(word) for word in properties)[:60]
        raise RangeError(f"{who}: motor_ctrl_properties ({words}) are for a motor control, but motor_ctrl names none")


def parse_properties(text: str, who: str) -> dict[str, str]:
    """Return the properties of words ``key=value``; a value with spaces stands in quotes.

    Raises:
        RangeError: If a word is of another form.
    """
    try:
        words = shlex.split(text)
    except ValueError:
        words = [text]
    pairs = [word.partition("=") for word in words]
    for (key, equals, _), word in zip(pairs, words, strict=True):
        if not (equals and key):
            raise RangeError(f"{who}: motor_ctrl_properties has the word '{word[:60]}', allowed: key=value")
    return {key: value for key, _, value in pairs}


def properties_text(properties: Mapping[str, object]) -> str:
    """Return properties as the text that `parse_properties` reads."""
    return " ".join(shlex.quote(f"{key}={value}") for key, value in properties.items())
