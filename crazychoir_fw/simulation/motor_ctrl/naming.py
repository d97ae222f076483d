"""From what a file says of a motor control to its class, and to its properties."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from difflib import get_close_matches
from types import ModuleType

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.common.user_code import anchored, describe, load_module
from crazychoir_fw.simulation.motor_ctrl.motor_ctrl import MotorCtrl
from crazychoir_fw.simulation.motor_ctrl.motor_ctrl_fpqr import MotorCtrlFPQR
from crazychoir_fw.simulation.motor_ctrl.motor_ctrl_frpy import MotorCtrlFRPY
from crazychoir_fw.simulation.motor_ctrl.motor_ctrl_vel import MotorCtrlVel
from crazychoir_fw.simulation.motor_ctrl.motor_ctrl_xyz import MotorCtrlXYZ

__all__ = ["STOCK", "anchored", "checked_class", "class_name", "describe", "find_class"]
__all__ += ["parse_properties", "properties_text", "require_class"]

STOCK = {cls.__name__: cls for cls in (MotorCtrlFPQR, MotorCtrlFRPY, MotorCtrlVel, MotorCtrlXYZ)}
"""Classes that are known by their plain names."""

FORMS = "package.module:Class, path/to/file.py:Class or one of " + ", ".join(STOCK)


def find_class(name: str, who: str) -> type[MotorCtrl]:
    """Return the class that a name means. A module or a file that it names is executed.

    Args:
        name: ``MotorCtrlFPQR`` and its like, ``package.module:Class``, or ``path/to/file.py:Class``.
        who: The drone, for messages.

    Raises:
        UnknownNameError: If there is no such module, file or class.
        RangeError: If the class is no `MotorCtrl`.
        CrazychoirError: If the module raises while it is imported; the message has the exception and the line.
    """
    module_name, colon, class_name = name.rpartition(":")
    if not colon:
        if name not in STOCK:
            near = get_close_matches(name, STOCK, n=1)
            hint = f" (did you mean {near[0]}?)" if near else ""
            raise UnknownNameError(f"{who}: motor_ctrl is '{name}'{hint}, allowed: {FORMS}")
        return STOCK[name]
    what = f"{who}: motor_ctrl '{name}'"
    module = load_module(module_name, what)
    found = getattr(module, class_name, None)
    if found is None:
        own = [value.__name__ for value in vars(module).values() if _is_own(value, module)]
        raise UnknownNameError(f"{what}: there is no such class, only {', '.join(own) or 'no motor control at all'}")
    return checked_class(found, what)


def _is_own(value: object, module: ModuleType) -> bool:
    return isinstance(value, type) and issubclass(value, MotorCtrl) and value.__module__ == module.__name__


def checked_class(found: object, what: str) -> type[MotorCtrl]:
    """Return a class that is a `MotorCtrl`.

    Raises:
        RangeError: If it is none.
    """
    if not (isinstance(found, type) and issubclass(found, MotorCtrl)):
        raise RangeError(f"{what}: {found!r} is no motor control, allowed: a subclass of MotorCtrl")
    return found


def class_name(cls: type[MotorCtrl]) -> str:
    """Return the name by which `find_class` finds a class again, as far as its module can be imported."""
    return cls.__name__ if STOCK.get(cls.__name__) is cls else f"{cls.__module__}:{cls.__qualname__}"


def require_class(who: str, motor_ctrl: object, properties: Mapping[str, object]) -> None:
    """Refuse properties that nobody would be told.

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
